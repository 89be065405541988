// Round trips of fields and groups with any names; changed names are reported.
#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

using namespace camber;

namespace {

/// Any name that a foreign file may have. None ends in X, Y or Z, because CGNS joins three of those to a vector.
std::string some_name(generated::Random& random) {
    static const std::vector<std::string> known{"",
                                                " ",
                                                "u",
                                                " u",
                                                "u ",
                                                "u_2",
                                                "a/b",
                                                "a_b",
                                                "reference",
                                                "dimension",
                                                "entity",
                                                "METADATA",
                                                "vtkGhostType",
                                                "GridLocation",
                                                "ZoneBC",
                                                ".",
                                                "..",
                                                "%20",
                                                "a%20b",
                                                "say \"it\"",
                                                "say 'it'",
                                                "<&>",
                                                "two\nlines",
                                                "two lines",
                                                "reference_2",
                                                "triangles_3",
                                                "edges_3",
                                                "tetrahedra_3",
                                                "reference_3",
                                                "\xCE\xBB\xE2\x82\xAC",
                                                "\xFF\xFE",
                                                "tab\there",
                                                "#1",
                                                "solid"};
    if (random.below(3) > 0) return known[random.below(known.size())];
    std::string name;
    const std::size_t size = random.below(60);
    constexpr std::string_view letters = "ab /_%\"<.\xC3\xA9\n";
    while (name.size() < size) name += letters[random.below(letters.size())];
    return name + "e";
}

AnyMesh some_mesh(std::uint64_t seed) {
    const std::size_t cells = 2 + seed % 10;
    return seed % 2 == 0 ? AnyMesh(as_mesh(generated::mesh<3>(seed, cells)))
                         : AnyMesh(as_mesh(generated::quadratic<3>(seed, cells)));
}

LinearMesh<3> linear_of(const AnyMesh& mesh) { return straight_simplices(std::get<Mesh<3>>(mesh)); }

/// A field with values that no other field has.
MeshField some_field(const AnyMesh& mesh, generated::Random& random, double first) {
    const LinearMesh<3> linear = linear_of(mesh);
    MeshField field{some_name(random),
                    random.below(2) == 0 ? Centring::node : Centring::cell,
                    random.below(3) == 0 ? FieldKind::vector : FieldKind::scalar,
                    {}};
    const std::size_t rows = field.centring == Centring::node
                                 ? count_nodes(std::get<Mesh<3>>(mesh))
                                 : linear.elements.size() + linear.facets.size() + linear.edges.size();
    Buffer<double> values(rows * static_cast<std::size_t>(values_per_vertex(field.kind, 3)));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = first + static_cast<double>(i) / 1024;
    field.values = Column<double>(std::move(values));
    return field;
}

bool same_values(const MeshField& a, const MeshField& b) {
    return a.centring == b.centring && a.kind == b.kind && a.values == b.values;
}

bool has_notice(const std::vector<Notice>& notices, const std::string& what) {
    return std::any_of(notices.begin(), notices.end(),
                       [&](const Notice& n) { return n.what.find(what) != std::string::npos; });
}

bool is_available(const MeshFormat& format) { return format.name != "cgns" || has_cgns_support(); }

}  // namespace

TEST_CASE("each format restores fields of any name and reports renamed ones") {
    for (const MeshFormat& format : mesh_formats()) {
        if (!format.encode || !format.decode || !format.has_fields || !is_available(format)) continue;
        const bool has_renames = format.renames != nullptr;
        REQUIRE(has_renames);
        testing::property(std::string(format.name), [&](std::uint64_t seed) {
            generated::Random random(seed);
            const AnyMesh mesh = some_mesh(seed);
            RC_PRE(generated::holds_simplices(linear_of(mesh)));
            MeshFields fields;
            for (std::size_t n = 1 + random.below(8); n > 0; --n) {
                MeshField field = some_field(mesh, random, static_cast<double>(n) * 4096);
                if (!format.can_store || format.can_store(field)) fields = std::move(fields).with(std::move(field));
            }
            const auto chunks = format.encode(mesh, fields, {}, {});
            if (!chunks) RC_FAIL(describe(chunks.error()));
            const auto back = decode_mesh(generated::joined(*chunks), "file.of-no-format", {});
            if (!back) RC_FAIL(describe(back.error()));
            RC_ASSERT(back->fields.size() == fields.size());
            const auto notices = format.renames(fields);
            RC_ASSERT(notices.size() <= 1U);
            std::size_t renamed = 0;
            for (const MeshField& field : fields) {
                const auto found = std::find_if(back->fields.begin(), back->fields.end(),
                                                [&](const MeshField& other) { return same_values(field, other); });
                RC_ASSERT((found != back->fields.end()));
                if ((*found).name == field.name) continue;
                ++renamed;
                if (renamed <= 4) RC_ASSERT(has_notice(notices, "becomes " + in_quotes((*found).name)));
            }
            RC_ASSERT((renamed > 0) == !notices.empty());
            RC_ASSERT(format.renames(back->fields).empty());
        });
    }
}

TEST_CASE("each format keeps groups of any name distinct and reports renamed ones") {
    for (const MeshFormat& format : mesh_formats()) {
        const std::set<std::string_view> with_names{"msh",  "msh-ascii", "msh2",     "msh2-ascii",
                                                    "mfem", "cgns",      "stl-ascii"};
        if (!with_names.contains(format.name) || !is_available(format)) continue;
        testing::property(std::string(format.name), [&](std::uint64_t seed) {
            generated::Random random(seed);
            auto mesh = generated::mesh<3>(seed, 2 + seed % 10);
            RC_PRE(mesh.elements.size() > 0);
            if (format.name == "stl-ascii") mesh.elements = {};
            const auto some_references = [&](auto& simplices) {
                Buffer<Reference> references;
                for (std::size_t i = 0; i < simplices.size(); ++i)
                    references.push_back(static_cast<Reference>(random.below(6)) - 1);
                simplices.references = std::move(references);
            };
            some_references(mesh.elements);
            some_references(mesh.facets);
            mesh.edges = {};
            mesh.ridges = {};
            RC_PRE(mesh.facets.size() > 0);
            std::map<std::pair<int, Reference>, std::string> names;
            Buffer<Group> groups;
            for (const int dimension : {2, 3})
                for (const Reference reference : {1, 2, 3, 4, 5})
                    if (random.below(3) > 0) {
                        groups.push_back({dimension, reference, some_name(random)});
                        names[{dimension, reference}] = groups.back().name;
                    }
            mesh.groups = groups;
            const auto chunks = format.encode(as_mesh(mesh), {}, {}, {});
            if (!chunks) RC_FAIL(describe(chunks.error()));
            const auto decoded = decode_mesh(generated::joined(*chunks), "file.of-no-format", {});
            if (!decoded) RC_FAIL(describe(decoded.error()));
            const auto& back = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
            std::set<std::pair<int, Reference>> before, after;
            const auto count = [](const LinearMesh<3>& m, auto& all) {
                for (const Reference r : m.elements.references) all.insert({3, r});
                for (const Reference r : m.facets.references) all.insert({2, r});
            };
            count(mesh, before);
            count(back, after);
            if (format.name != "mfem" && format.name != "stl-ascii")  // these store other facets, or triangles
                RC_ASSERT(before.size() == after.size());
            // Different names stay different in the file, and references without a name get none of them.
            std::map<std::pair<int, std::string>, std::set<Reference>> references_of;
            for (const Group& group : back.groups) references_of[{group.dimension, group.name}].insert(group.reference);
            const auto losses = format.losses(as_mesh(mesh));
            for (const auto& [key, name] : names) {
                if (!before.contains(key)) continue;
                const auto found = references_of.find({key.first, name});
                const bool is_preserved = found != references_of.end();
                if (!is_preserved && format.name != "mfem")
                    RC_ASSERT(
                        (has_notice(losses, "names of references") || has_notice(losses, "references as solids")));
            }
        });
    }
}

TEST_CASE("VTK, VTU, CGNS and MSH report the new names of invalid field names") {
    const auto field = [](const char* name, Centring centring) {
        return MeshField{name, centring, FieldKind::scalar, Column<double>()};
    };
    const auto renamed = [](std::string_view format, const std::vector<MeshField>& fields) {
        const auto notices = format_with_name(mesh_formats(), format)->renames(MeshFields(fields));
        return notices.empty() ? std::string() : notices.front().what;
    };
    const auto at_node = [&](const char* name) { return field(name, Centring::node); };
    CHECK(renamed("vtk", {at_node(""), at_node("reference"), at_node("reference_2")}) ==
          "VTK cannot hold 2 names of fields: \"\" becomes \"unnamed\", \"reference\" becomes \"reference_3\"");
    CHECK(renamed("vtu", {field("entity", Centring::cell), at_node("entity")}) ==
          "VTU cannot hold 1 names of fields: \"entity\" becomes \"entity_2\"");
    CHECK(renamed("cgns", {at_node(" u"), at_node("u")}) ==
          "CGNS cannot hold 1 names of fields: \" u\" becomes \"u_2\"");
    CHECK(renamed("cgns", {at_node("12345678901234567890123456789012 and more"), at_node("a/b")}) ==
          "CGNS cannot hold 2 names of fields: \"12345678901234567890123456789012 and more\" becomes "
          "\"12345678901234567890123456789012\", \"a/b\" becomes \"a_b\"");
    CHECK(renamed("cgns", {{"v", Centring::node, FieldKind::vector, Column<double>()}, at_node("vX")}) ==
          "CGNS cannot hold 1 names of fields: \"vX\" becomes \"vX_2\"");
    CHECK(renamed("msh", {at_node(""), at_node("say \"it\""), at_node("say 'it'")}) ==
          "MSH cannot hold 1 names of fields: \"say \"it\"\" becomes \"say 'it'_2\"");
    CHECK(renamed("vtu", {at_node("u")}).empty());
}
