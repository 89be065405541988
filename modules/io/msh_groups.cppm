module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>
module camber.io:msh_groups;
import camber.core;
import :legal_names;
import :msh_numbers;
import :msh_raw;
import :notice;

/// Simplices in several physical groups. In a file each group has a tag, and a simplex is in any number of them. In a
/// mesh a simplex has one reference, and a reference has a name for each group that its simplices are in: the first
/// group of `LinearMesh::groups` with a reference is its main one. A name stands for one tag: the lowest reference that
/// it is the main name of.
namespace camber::msh {

/// Replaces the first physical tags by references: simplices with other sets of tags have other references. The lowest
/// set of those with the same first tag has that as its reference, each of the others the next number after all tags.
/// Adds the names of further groups to `groups`; groups without a name that share simplices with others get one.
void give_references(File& file, Buffer<Group>& groups, std::vector<Notice>& notices);

/// Names in quotes, which end in their line. None at all is one too.
[[nodiscard]] inline NameRule name_rule() { return {.legal = quotable_name, .unnamed = {}}; }
[[nodiscard]] inline FieldNames field_names() { return {name_rule(), name_rule()}; }

/// A physical group of the file with its name.
struct NamedTag {
    int dimension = 0;
    Reference tag = 0;
    std::string name;
};

/// The physical tags of a file, by the mesh's references.
class GroupTags {
  public:
    GroupTags(const Column<Group>& groups, const Numbers& numbers);

    /// The groups that have a name, each tag once.
    [[nodiscard]] const std::vector<NamedTag>& named() const { return named_; }
    /// The tags of a class of simplices of that dimension: none in no group, the main one first.
    [[nodiscard]] std::vector<Reference> of(int dimension, const Class& simplices) const;

  private:
    std::vector<NamedTag> named_;
    std::map<std::pair<int, Reference>, std::vector<Reference>> of_several_;  ///< references with several names
};

}  // namespace camber::msh
