module;
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace gmf {

Outcome<int> chosen_version(GmfOptions options, int least) {
    if (options.version == 0) return least;
    if (options.version < 2 || options.version > 4)
        return fail(ErrorKind::usage, "GMF version " + std::to_string(options.version) + " is not 2, 3 or 4");
    if (options.version < least)
        return fail(ErrorKind::usage, "the file does not fit GMF version " + std::to_string(options.version), {}, {},
                    "use version " + std::to_string(least));
    return options.version;
}

namespace {

template <class Sink, class Mesh>
Outcome<Chunks> written(Sink sink, const Mesh& mesh) {
    auto done = put_mesh(sink, mesh);
    if (!done) return fail(std::move(done.error()));
    return std::move(sink).finish();
}

template <class Mesh>
Outcome<Chunks> encode(const Mesh& mesh, GmfOptions options, const Execution& execution) {
    BinarySizer sizer;
    if (auto sized = put_mesh(sizer, mesh); !sized) return fail(std::move(sized.error()));
    const bool ascii = options.encoding == GmfEncoding::ascii;
    const auto version = chosen_version(options, ascii ? 2 : sizer.min_version());
    if (!version) return fail(version.error());
    const std::size_t words = sizer.words();
    if (ascii) return written(AsciiWriter(*version, words, execution), mesh);
    return with_written_layout(*version, [&](auto layout) {
        return written(BinaryWriter<decltype(layout)>(*version, words, execution), mesh);
    });
}

template <int D>
bool is_sound(const LinearMesh<D>& mesh) {
    return mesh.point_references.size() == mesh.points.size() &&
           mesh.elements.references.size() == mesh.elements.size() &&
           mesh.facets.references.size() == mesh.facets.size() && mesh.edges.references.size() == mesh.edges.size();
}

auto broken() {
    return fail(ErrorKind::internal, "the columns of the mesh do not have the lengths that belong together");
}

}  // namespace

}  // namespace gmf

template <int D>
Outcome<Chunks> encode_gmf_mesh(const LinearMesh<D>& mesh, GmfOptions options, const Execution& execution) {
    if (!gmf::is_sound(mesh)) return gmf::broken();
    return guarded([&] { return gmf::encode(mesh, options, execution); });
}

template <int D>
Outcome<Chunks> encode_gmf_mesh(const QuadraticMesh<D>& mesh, GmfOptions options, const Execution& execution) {
    const LinearMesh<D>& linear = mesh.linear;
    if (!gmf::is_sound(linear) || mesh.mid_nodes.size() != mesh.edges.size() ||
        mesh.edges.of_elements.size() != linear.elements.size() ||
        mesh.edges.of_facets.size() != linear.facets.size() || mesh.edges.of_edges.size() != linear.edges.size())
        return gmf::broken();
    return guarded([&] { return gmf::encode(mesh, options, execution); });
}

template <int D>
std::vector<Notice> not_in_gmf(const LinearMesh<D>& mesh) {
    std::size_t no_parameters = 0, no_distance = 0;
    const auto count = [&](const auto& associations) {
        for (const auto& on : associations)
            if (!gmf::is_in_gmf(on))
                ++no_parameters;
            else if (!on.distance)
                ++no_distance;
    };
    count(mesh.geometry.on_curves);
    count(mesh.geometry.on_surfaces);
    std::vector<Notice> losses = not_held(
        mesh, {.associations = true, .corners = true, .ridges = true, .required = true, .directions = true}, "GMF");
    if (no_parameters > 0)
        losses.push_back({"GMF has no place for " + std::to_string(no_parameters) +
                          " associations with curves and surfaces whose parameters are not known"});
    if (no_distance > 0)
        losses.push_back({"GMF has no word for the distances from curves and surfaces that are not known: " +
                          std::to_string(no_distance) + " are written as 0"});
    return losses;
}

#define CAMBER_INSTANTIATE(D)                                                                        \
    template std::vector<Notice> not_in_gmf<D>(const LinearMesh<D>&);                                \
    template Outcome<Chunks> encode_gmf_mesh<D>(const LinearMesh<D>&, GmfOptions, const Execution&); \
    template Outcome<Chunks> encode_gmf_mesh<D>(const QuadraticMesh<D>&, GmfOptions, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
