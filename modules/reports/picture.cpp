// Pictures of meshes
module;
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.drawing;
import camber.metric;
import camber.validity;
import camber.io;

namespace camber::run {

namespace {

/// Values that the colours of a picture show.
struct PictureValues {
    FaceValues of_face;
    Colouring colouring = OneColour{};
    std::string title = {};
};

using References = std::vector<Reference>;  ///< ascending, unique

void sort_distinct(References& references) {
    std::ranges::sort(references);
    references.erase(std::unique(references.begin(), references.end()), references.end());
}

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

struct Extent {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
};
Extent extent_of(const Column<float>& values) {
    Extent e;
    for (const float v : values)
        if (std::isfinite(v)) e = {std::fmin(e.low, static_cast<double>(v)), std::fmax(e.high, static_cast<double>(v))};
    return e.low <= e.high ? e : Extent{0, 1};
}

FaceValues by_element(Column<float> values) {
    return [values = std::move(values)](const Face& face) {
        std::array<float, 6> all{};
        all.fill(values[face.element]);
        return all;
    };
}
FaceValues by_node(Column<float> values) {
    return [values = std::move(values)](const Face& face) {
        std::array<float, 6> all{};
        for (std::size_t i = 0; i < 6; ++i) all[i] = values[face.nodes[i]];
        return all;
    };
}

/// The colours range from 0 to 1, so that pictures of different meshes are comparable. If a value is negative, the
/// range begins at the minimum.
PictureValues of_goodness(Column<float> values, std::string title) {
    const double low = std::clamp(extent_of(values).low, -1.0, 0.0);
    return {by_element(std::move(values)), ColourRange{low, 1, Ramp::good_is_high}, std::move(title)};
}

template <int D>
Outcome<Column<float>> qualities(const QuadraticMesh<D>& mesh, const Execution& execution) {
    return map_each(execution, judged_count(mesh.linear),
                    [&](std::size_t e) { return static_cast<float>(quality_of(mesh.linear, e)); })
        .map([](auto result) { return Column<float>(std::move(result)); });
}

template <int D>
PictureValues of_references(const QuadraticMesh<D>& mesh) {
    ColourKinds kinds;
    const auto add = [&](const Column<Reference>& references) {
        kinds.numbers.insert(kinds.numbers.end(), references.begin(), references.end());
    };
    add(mesh.linear.elements.references);
    if (D == 3) add(mesh.linear.facets.references);
    sort_distinct(kinds.numbers);
    FaceValues places = [numbers = kinds.numbers](const Face& face) {
        const auto found = std::lower_bound(numbers.begin(), numbers.end(), face.reference);
        const bool is_listed = found != numbers.end() && *found == face.reference;
        std::array<float, 6> all{};
        all.fill(is_listed ? static_cast<float>(found - numbers.begin()) : nan);
        return all;
    };
    return {std::move(places), std::move(kinds), "reference"};
}

/// Extends vertex values to all nodes: edge nodes get the mean of the ends.
template <int D>
Column<float> at_all_nodes(const QuadraticMesh<D>& mesh, const Column<double>& values) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<float> all(vertices + mesh.edges.size());
    std::fill(all.begin(), all.end(), nan);
    for (std::size_t n = 0; n < std::min(values.size(), all.size()); ++n) all[n] = static_cast<float>(values[n]);
    if (values.size() == vertices)
        for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
            const auto [a, b] = mesh.edges.vertices[e];
            all[vertices + e] = (all[a.index()] + all[b.index()]) / 2;
        }
    return all;
}

template <int D>
Outcome<PictureValues> of_anisotropy(const QuadraticMesh<D>& mesh, const MetricFile& file, const Execution& execution) {
    const auto metric = log_metrics_of_file<D>(file, mesh.linear.points.size(), execution);
    if (!metric) return fail(metric.error());
    auto ratios = map_each(execution, metric->log_metrics.size(), [&](std::size_t v) {
        const SpectralMetric<D> m(metric->log_metrics[v]);
        double low = m.log_values[0], high = low;
        for (int i = 1; i < D; ++i) {
            low = std::fmin(low, m.log_values[i]);
            high = std::fmax(high, m.log_values[i]);
        }
        return exp((high - low) / 2);
    });
    if (!ratios) return fail(ratios.error());
    Column<float> values = at_all_nodes(mesh, Column<double>(std::move(*ratios)));
    const double high = std::fmax(extent_of(values).high, 1.0 + 1e-9);
    return PictureValues{by_node(std::move(values)),
                         ColourRange{1, high, Ramp::plain, high > 10 ? Spacing::logarithmic : Spacing::linear},
                         "anisotropy"};
}

template <int D>
PictureValues of_solution(const QuadraticMesh<D>& mesh, const NamedField& field) {
    const auto components = static_cast<std::size_t>(field.field.components);
    Buffer<double> lengths(field.field.values.size() / components);
    for (std::size_t n = 0; n < lengths.size(); ++n) {
        double squares = 0;
        for (std::size_t c = 0; c < components; ++c) {
            const double x = field.field.values[n * components + c];
            squares += x * x;
        }
        lengths[n] = components == 1 ? field.field.values[n] : std::sqrt(squares);
    }
    Column<float> values = at_all_nodes(mesh, Column<double>(std::move(lengths)));
    const Extent extent = extent_of(values);
    return {by_node(std::move(values)), ColourRange{extent.low, extent.high},
            components == 1 ? field.name : "length of " + field.name};
}

/// Returns scaled Jacobians (degree 2) or qualities (degree 1) of elements, or of triangles of a standalone surface.
template <int D>
Outcome<Column<float>> element_goodness(const QuadraticMesh<D>& mesh, int degree, const Execution& execution) {
    if (degree == 1) return qualities(mesh, execution);
    return validate(mesh, 0, execution).map([](const Validation<D>& v) { return v.min_scaled_jacobian; });
}

template <int D>
Outcome<PictureValues> picture_values(const QuadraticMesh<D>& mesh, PictureColour colour, const PictureInputs& inputs,
                                      const Execution& execution) {
    switch (colour) {
        case PictureColour::scaled_jacobian:
            return element_goodness(mesh, 2, execution).map([](Column<float> values) {
                return of_goodness(std::move(values), "scaled Jacobian");
            });
        case PictureColour::quality:
            return qualities(mesh, execution).map([](Column<float> values) {
                return of_goodness(std::move(values), "quality");
            });
        case PictureColour::reference: return of_references(mesh);
        case PictureColour::anisotropy:
            if (!inputs.metric)
                return fail(ErrorKind::usage, "needs a metric", "--colour anisotropy", {}, "give --metric FILE");
            return of_anisotropy(mesh, *inputs.metric, execution);
        case PictureColour::solution:
            if (!inputs.solution)
                return fail(ErrorKind::usage, "needs a solution", "--colour solution", {}, "give --solution FILE");
            return of_solution(mesh, *inputs.solution);
        case PictureColour::none: break;
    }
    return PictureValues{[](const Face&) { return std::array<float, 6>{}; }};
}

PictureColour usual_colour(const PictureInputs& inputs, int degree) {
    if (inputs.solution) return PictureColour::solution;
    if (inputs.metric) return PictureColour::anisotropy;
    return degree == 2 ? PictureColour::scaled_jacobian : PictureColour::quality;
}

/// Oblique from the front, or towards the faces that a cut uncovers.
View usual_view(const std::optional<Cut<3>>& cut) {
    if (!cut) return view_from(Vec<3>{{1, -1.6, 0.9}});
    const Vec<3> n = normalised(cut->normal);
    const View straight = view_from(n);
    return view_from(n - 0.45 * straight.right + 0.35 * straight.up);
}
template <int D>
View view_of(const PictureChoice& choice) {
    if constexpr (D == 2)
        return View{};
    else
        return choice.from ? view_from(*choice.from) : usual_view(choice.cut);
}

template <int D>
Cut<D> cut_in(const Cut<3>& cut) {
    Cut<D> own{{}, cut.offset};
    for (int i = 0; i < D; ++i) own.normal[i] = cut.normal[i];
    return own;
}

template <int K, int D>
Vec<3> middle_of(const QuadraticMesh<D>& mesh, const SimplexVertices<K>& vertices,
                 const std::array<EdgeId, edges_per_simplex<K>>& edges) {
    std::array<double, K + 1> xi{};
    xi.fill(1.0 / (K + 1));
    Vec<3> middle{};
    for (const VertexId v : vertices) middle += vertex_shape(xi[0]) * in_space(mesh.linear.points[v]);
    for (const EdgeId e : edges) middle += edge_shape<K>(xi, 0) * in_space(mesh.mid_nodes[e].point);
    return middle;
}
template <int D>
Vec<3> middle_of(const QuadraticMesh<D>& mesh, std::size_t e) {
    if (is_standalone_surface(mesh.linear))
        return middle_of<D - 1>(mesh, mesh.linear.facets.vertices[e], mesh.edges.of_facets[e]);
    return middle_of<D>(mesh, mesh.linear.elements.vertices[e], mesh.edges.of_elements[e]);
}

/// Returns the numbers of the `count` worst elements, the worst first.
std::vector<std::uint32_t> worst_of(const Column<float>& goodness, std::size_t count) {
    std::vector<std::uint32_t> order(goodness.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&](std::uint32_t e) { return std::isnan(goodness[e]) ? -HUGE_VALF : goodness[e]; };
    const std::size_t shown = std::min(count, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(shown), order.end(),
                      [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    order.resize(shown);
    return order;
}

References distinct(const Column<Reference>& references) {
    References all(references.begin(), references.end());
    sort_distinct(all);
    return all;
}
bool contains(const References& references, Reference reference) {
    return std::binary_search(references.begin(), references.end(), reference);
}

/// References of boundary facets and of elements. 2D meshes have no facets here. Triangles of a standalone surface mesh
/// are elements.
struct GroupReferences {
    References facets, elements;
};

template <int D>
class PictureGroups {
  public:
    explicit PictureGroups(const LinearMesh<D>& mesh) : mesh_(mesh), is_surface_(is_standalone_surface(mesh)) {
        existing_.elements = distinct(is_surface_ ? mesh.facets.references : mesh.elements.references);
        if (D == 3 && !is_surface_) existing_.facets = distinct(mesh.facets.references);
    }

    [[nodiscard]] bool has_facets() const { return D == 3 && !is_surface_; }
    [[nodiscard]] int dimension() const { return is_surface_ ? 2 : D; }

    /// References that a list of names and numbers selects. A number selects boundary facets, or elements if no facet
    /// has it.
    [[nodiscard]] Outcome<GroupReferences> selected(const std::vector<std::string>& list,
                                                    std::string_view option) const {
        GroupReferences found;
        for (const std::string& text : list)
            if (!add_named(text, found) && !add_numbered(text, found))
                return fail(ErrorKind::usage, "the mesh has no group and no reference " + in_quotes(text),
                            std::string(option), {}, all());
        sort_distinct(found.facets);
        sort_distinct(found.elements);
        return found;
    }

    [[nodiscard]] std::string name_of(int dimension, Reference reference) const {
        std::string name;
        for (const Group& group : mesh_.groups)
            if (group.dimension == dimension && group.reference == reference)
                name += (name.empty() ? "" : ", ") + group.name;
        return name;
    }

  private:
    bool add_named(const std::string& name, GroupReferences& found) const {
        bool is_found = false;
        for (const Group& group : mesh_.groups) {
            const bool is_of_facets = has_facets() && group.dimension == 2;
            if (group.name != name || (!is_of_facets && group.dimension != dimension())) continue;
            (is_of_facets ? found.facets : found.elements).push_back(group.reference);
            is_found = true;
        }
        return is_found;
    }
    bool add_numbered(const std::string& text, GroupReferences& found) const {
        Reference number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error != std::errc{} || end != text.data() + text.size()) return false;
        const bool is_of_facets = contains(existing_.facets, number);
        if (!is_of_facets && !contains(existing_.elements, number)) return false;
        (is_of_facets ? found.facets : found.elements).push_back(number);
        return true;
    }

    [[nodiscard]] std::string listed(const References& references, int dimension) const {
        constexpr std::size_t most = 30;
        std::string text;
        for (std::size_t i = 0; i < std::min(most, references.size()); ++i) {
            const std::string name = name_of(dimension, references[i]), number = std::to_string(references[i]);
            text += (i > 0 ? ", " : "") + (name.empty() ? number : name + " (" + number + ")");
        }
        if (references.size() > most) text += " and " + std::to_string(references.size() - most) + " more";
        return text;
    }
    [[nodiscard]] std::string all() const {
        if (!has_facets()) return "there are: " + listed(existing_.elements, dimension());
        return "there are: of boundary facets " + (existing_.facets.empty() ? "none" : listed(existing_.facets, 2)) +
               "; of elements " + listed(existing_.elements, dimension());
    }

    const LinearMesh<D>& mesh_;
    bool is_surface_;
    GroupReferences existing_;
};

struct PictureFaces {
    Column<Face> faces;
    bool is_open = false;  ///< inner sides of the boundary can be visible
};

/// Marks with 1 the elements or facets inside the cut whose reference is in `list`; with `is_included` false, those
/// whose reference is not in `list`.
Column<std::uint8_t> with_references(const Column<Reference>& references, const References& list, bool is_included,
                                     const Column<std::uint8_t>& inside_cut) {
    Buffer<std::uint8_t> out(references.size());
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = static_cast<std::uint8_t>((inside_cut.empty() || inside_cut[i] != 0) &&
                                           contains(list, references[i]) == is_included);
    return Column<std::uint8_t>(std::move(out));
}

template <int D>
Outcome<PictureFaces> picture_faces(const QuadraticMesh<D>& mesh, const PictureChoice& choice,
                                    const PictureGroups<D>& groups, const Execution& execution) {
    const Mesh<D> drawn = as_mesh(mesh);
    const auto shown = groups.selected(choice.show, "--show"), hidden = groups.selected(choice.hide, "--hide");
    if (!shown) return fail(shown.error());
    if (!hidden) return fail(hidden.error());
    Column<std::uint8_t> inside_cut;
    if (choice.cut) {
        auto found = elements_inside_cut(cut_in<D>(*choice.cut), drawn, without_progress(execution));
        if (!found) return fail(found.error());
        inside_cut = std::move(*found);
    }
    const LinearMesh<D>& linear = mesh.linear;
    const Column<Reference>& references =
        is_standalone_surface(linear) ? linear.facets.references : linear.elements.references;
    const bool is_limited = !choice.show.empty();
    if (!hidden->elements.empty()) inside_cut = with_references(references, hidden->elements, false, inside_cut);
    if (!groups.has_facets() && is_limited) inside_cut = with_references(references, shown->elements, true, inside_cut);
    const bool is_open = !shown->facets.empty() || !hidden->facets.empty();
    if constexpr (D == 3)
        if (groups.has_facets() && (is_limited || is_open)) {
            const auto bodies =
                is_limited ? with_references(references, shown->elements, true, {}) : Column<std::uint8_t>{};
            return faces_to_draw(drawn, inside_cut.view(), {bodies.view(), shown->facets, hidden->facets}, execution)
                .map([&](Column<Face> faces) { return PictureFaces{std::move(faces), is_open}; });
        }
    return faces_to_draw(drawn, inside_cut.view(), execution).map([](Column<Face> faces) {
        return PictureFaces{std::move(faces)};
    });
}

/// Adds names of the drawn groups. If groups are hidden or have names, the legend only lists drawn groups.
template <int D>
void name_kinds(const Column<Face>& faces, const PictureGroups<D>& groups, bool is_limited, PictureValues& values) {
    auto* kinds = std::get_if<ColourKinds>(&values.colouring);
    if (!kinds) return;
    std::set<std::pair<Reference, int>> drawn;
    for (const Face& face : faces)
        drawn.emplace(face.reference,
                      face.kind == FaceKind::uncovered || !groups.has_facets() ? groups.dimension() : 2);
    std::vector<std::string> names(kinds->numbers.size());
    std::vector<std::uint8_t> is_listed(kinds->numbers.size());
    bool has_names = false;
    for (const auto& [reference, dimension] : drawn) {
        const auto at = std::lower_bound(kinds->numbers.begin(), kinds->numbers.end(), reference);
        if (at == kinds->numbers.end() || *at != reference) continue;
        const auto place = static_cast<std::size_t>(at - kinds->numbers.begin());
        const std::string name = groups.name_of(dimension, reference);
        is_listed[place] = 1;
        if (!name.empty() && !names[place].empty() && names[place] != name) names[place] += ", " + name;
        if (names[place].empty()) names[place] = name;
        has_names = has_names || !name.empty();
    }
    if (is_limited || has_names) kinds->is_listed = std::move(is_listed);
    if (!has_names) return;
    kinds->names = std::move(names);
    values.title = "group";
}

/// Argument of --cut, as "x=0.25", for a plane that keeps an element and removes elements next to it.
template <int D>
std::string cut_beside(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto centroid_and_size = [&](const auto& vertices) {
        Vec<D> centroid{};
        for (const VertexId v : vertices) centroid += mesh.linear.points[v] / static_cast<double>(vertices.size());
        return std::pair(centroid, distance(centroid, mesh.linear.points[vertices[0]]));
    };
    const auto [centroid, size] = is_standalone_surface(mesh.linear)
                                      ? centroid_and_size(mesh.linear.facets.vertices[e])
                                      : centroid_and_size(mesh.linear.elements.vertices[e]);
    // Rounds up to few digits, so that the cut keeps the element.
    const double step = pow(10, std::floor(log10(std::fmax(0.02 * size, 1e-12))));
    return fmt::format("x={:.10g}", (std::floor(centroid[0] / step) + 1) * step);
}

/// Marks the visible worst elements, and adds a note on the number of others.
template <int D>
Outcome<Done> point_at_worst(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& worst,
                             const Column<Face>& faces, Picture& picture, const Execution& execution) {
    const auto visible = visible_faces(picture.scene, execution);
    if (!visible) return fail(visible.error());
    std::vector<std::uint32_t> shown_elements;
    shown_elements.reserve(visible->size());
    for (const std::uint32_t f : *visible) shown_elements.push_back(faces[f].element);
    std::sort(shown_elements.begin(), shown_elements.end());
    std::vector<std::size_t> not_drawn;
    for (std::size_t i = 0; i < worst.size(); ++i)
        if (std::binary_search(shown_elements.begin(), shown_elements.end(), worst[i]))
            picture.scene.options.pointers.push_back({middle_of(mesh, worst[i]), std::to_string(i + 1)});
        else
            not_drawn.push_back(i);
    if (not_drawn.empty()) return Done{};
    std::string note = fmt::format("{} of the {} worst elements cannot be seen and {} not marked. ", not_drawn.size(),
                                   worst.size(), not_drawn.size() == 1 ? "is" : "are");
    if (D == 3 && !is_standalone_surface(mesh.linear))
        note += fmt::format("A cut next to an element shows it: --cut {} for number {}",
                            cut_beside(mesh, worst[not_drawn[0]]), not_drawn[0] + 1);
    else
        note += "Draw the mesh without --cut, --show, --hide and --zoom, or from another side";
    picture.notices.push_back(std::move(note));
    return Done{};
}

template <int D>
Outcome<Picture> picture(const PictureInputs& inputs, const PictureChoice& choice, int degree,
                         const Execution& execution) {
    const auto mesh = of_degree_2<D>(inputs.mesh.mesh, part_of(execution, 0, 0.2));
    if (!mesh) return fail(mesh.error());
    const PictureGroups<D> groups(mesh->linear);
    const auto drawn = picture_faces(*mesh, choice, groups, part_of(execution, 0.2, 0.5));
    if (!drawn) return fail(drawn.error());
    auto values = picture_values(*mesh, choice.colour.value_or(usual_colour(inputs, degree)), inputs,
                                 part_of(execution, 0.5, 0.8));
    if (!values) return fail(values.error());
    name_kinds(drawn->faces, groups, !choice.show.empty() || !choice.hide.empty(), *values);
    PictureOptions options{choice.width,
                           choice.height,
                           choice.background,
                           choice.edges,
                           std::move(values->colouring),
                           std::move(values->title),
                           view_of<D>(choice),
                           choice.zoom};
    std::vector<std::uint32_t> worst;
    if (choice.worst > 0) {
        const auto goodness = element_goodness(*mesh, degree, part_of(execution, 0.8, 0.9));
        if (!goodness) return fail(goodness.error());
        worst = worst_of(*goodness, choice.worst);
    }
    std::vector<std::uint32_t> marked = worst;
    std::sort(marked.begin(), marked.end());
    auto scene = make_scene(as_mesh(*mesh), drawn->faces.view(), values->of_face, marked, std::move(options),
                            part_of(execution, 0.9, 0.95));
    if (!scene) return fail(scene.error());
    Picture picture{std::move(*scene)};
    if (drawn->is_open) picture.scene.sides = VisibleSides::both;
    if (worst.empty()) return picture;
    return point_at_worst(*mesh, worst, drawn->faces, picture, part_of(execution, 0.95, 1)).map([&](Done) {
        return std::move(picture);
    });
}

}  // namespace

Outcome<Picture> picture_of(const PictureInputs& inputs, const PictureChoice& choice, const Execution& execution) {
    return std::visit([&]<int D>(const Mesh<D>& mesh) { return picture<D>(inputs, choice, mesh.degree, execution); },
                      inputs.mesh.mesh);
}

}  // namespace camber::run
