module;
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <nlohmann/json.hpp>
module camber.config:description;
import camber.core;
import camber.metric;
import camber.solution_metric;
import camber.surface;
import camber.recipes;
import camber.shapes;
import camber.fields;
import :codec;

namespace camber::config {

/// Address of a member in a struct of unknown type.
class Member {
  public:
    template <class S, class T>
    Member(T S::* member)  // NOLINT(*-explicit-*)
        : address_([member](void* in) -> void* { return &(static_cast<S*>(in)->*member); }) {}

    [[nodiscard]] void* of(void* in) const { return address_(in); }
    [[nodiscard]] const void* of(const void* in) const { return address_(const_cast<void*>(in)); }

  private:
    std::function<void*(void*)> address_;
};

struct Choice;

/// Description of a struct's field for reading, writing, explanation and schema.
struct Field {
    Member member;
    const Codec* codec;
    std::string name, doc, unit_name;
    Limits limits;
    bool is_required;
    /// Name of the field, or the keys of an inlined choice, of which exactly one must appear.
    std::vector<std::string> keys;
    const Choice* inlined = nullptr;  ///< codec of an inlined choice

    Outcome<Done> read(const std::string& key, const Json& json, const Place& place, void* into) const;
    void write(const void* from, Json& object) const;
    [[nodiscard]] Json schema(const std::string& key) const;
    [[nodiscard]] std::string type() const { return codec->type(limits); }
};

struct Description : Codec {
    std::string name, doc;
    std::vector<Field> fields;
    Json (*defaults)();
    /// Checks a struct whose fields are valid. Returns the error; empty: valid.
    std::function<std::string(const void*)> check;

    Outcome<Done> read(const Json& json, const Place& place, const Limits&, void* into) const override;
    Json write(const void* value) const override;
    Json schema(const Limits&) const override;
    std::string type(const Limits&) const override { return "object, see " + name; }
    /// True if all fields have defaults.
    bool may_be_bare() const override;
};

struct Alternative {
    std::string key, doc;
    const Codec* codec;
    /// Assigns the alternative's default value and returns its address.
    void* (*emplace)(void* variant);
};

/// Description of a variant: an object with one key, or a bare key without options.
struct Choice : Codec {
    std::string name, doc;
    std::vector<Alternative> alternatives;  ///< in the variant's order
    std::pair<std::size_t, const void*> (*alternative_of)(const void* variant) = nullptr;

    [[nodiscard]] std::vector<std::string> keys() const;
    /// Null if there is no such key.
    [[nodiscard]] const Alternative* find(std::string_view key) const;
    [[nodiscard]] const std::string& key(const void* variant) const {
        return alternatives[alternative_of(variant).first].key;
    }
    [[nodiscard]] Json options(const void* variant) const;
    /// Null options stand for the bare key.
    Outcome<Done> read_key(const std::string& key, const Json& options, const Place&, const Limits&, void* into) const;

    Outcome<Done> read(const Json& json, const Place& place, const Limits& limits, void* into) const override;
    Json write(const void* variant) const override;
    Json schema(const Limits& limits) const override;
    std::string type(const Limits&) const override;
};

/// A struct that is written as its only member.
struct Wrapper : Codec {
    Member member;
    const Codec& (*codec)();
    std::optional<Limits> limits;  ///< none: those of the option
    std::string type_name;         ///< empty: that of the member

    template <class S, class T>
    explicit Wrapper(T S::* only, std::optional<Limits> own_limits = {}, std::string own_name = {})
        : member(only), codec(codec_of<T>), limits(own_limits), type_name(std::move(own_name)) {}

    Outcome<Done> read(const Json& json, const Place& place, const Limits& specified, void* into) const override {
        return codec().read(json, place, limits.value_or(specified), member.of(into));
    }
    Json write(const void* value) const override { return codec().write(member.of(value)); }
    Json schema(const Limits& specified) const override { return codec().schema(limits.value_or(specified)); }
    std::string type(const Limits& specified) const override {
        return type_name.empty() ? codec().type(limits.value_or(specified)) : type_name;
    }
};

/// `make` is defined in describe_*.cpp.
#define CAMBER_DESCRIBED(...)                       \
    template <>                                     \
    struct Described<__VA_ARGS__> {                 \
        static CAMBER_KIND make();                  \
        static const CAMBER_KIND& get() {           \
            static const CAMBER_KIND only = make(); \
            return only;                            \
        }                                           \
    };
#define CAMBER_KIND Description
CAMBER_DESCRIBED(BoundaryLayer)
CAMBER_DESCRIBED(ShellOptions<3>)
CAMBER_DESCRIBED(ShellOptions<2>)
CAMBER_DESCRIBED(BoxOptions<3>)
CAMBER_DESCRIBED(BoxOptions<2>)
CAMBER_DESCRIBED(BumpOptions)
CAMBER_DESCRIBED(NaturalMetric)
CAMBER_DESCRIBED(ConstantMetric)
CAMBER_DESCRIBED(SurfaceMetric)
CAMBER_DESCRIBED(ReferenceSize)
CAMBER_DESCRIBED(GeometryMetric)
CAMBER_DESCRIBED(SolutionMetric)
CAMBER_DESCRIBED(LinearField)
CAMBER_DESCRIBED(PolarOneField)
CAMBER_DESCRIBED(PolarTwoField)
CAMBER_DESCRIBED(PlanarShock)
CAMBER_DESCRIBED(SphericalShock)
CAMBER_DESCRIBED(RotatingField)
CAMBER_DESCRIBED(Gradation)
CAMBER_DESCRIBED(Bound)
CAMBER_DESCRIBED(Complexity)
CAMBER_DESCRIBED(Surrogate)
CAMBER_DESCRIBED(Straight)
CAMBER_DESCRIBED(Plane)
CAMBER_DESCRIBED(Sphere)
CAMBER_DESCRIBED(Cylinder)
CAMBER_DESCRIBED(Torus)
CAMBER_DESCRIBED(AnalyticSurface)
CAMBER_DESCRIBED(Cad)
CAMBER_DESCRIBED(Input)
CAMBER_DESCRIBED(SolutionInput)
CAMBER_DESCRIBED(Features)
CAMBER_DESCRIBED(BoundaryTolerance)
CAMBER_DESCRIBED(Elevate)
CAMBER_DESCRIBED(Curve)
CAMBER_DESCRIBED(Validate)
CAMBER_DESCRIBED(Relax)
CAMBER_DESCRIBED(Commit)
CAMBER_DESCRIBED(Reinsert)
CAMBER_DESCRIBED(Collapse)
CAMBER_DESCRIBED(Split)
CAMBER_DESCRIBED(Swap)
CAMBER_DESCRIBED(Smooth)
CAMBER_DESCRIBED(Mend)
CAMBER_DESCRIBED(Remesh)
CAMBER_DESCRIBED(Adaptation)
CAMBER_DESCRIBED(Output)
CAMBER_DESCRIBED(Pipeline)
#undef CAMBER_KIND
#define CAMBER_KIND Choice
CAMBER_DESCRIBED(Shape)
CAMBER_DESCRIBED(MeshSource)
CAMBER_DESCRIBED(Metric)
CAMBER_DESCRIBED(FieldMetric)
CAMBER_DESCRIBED(MetricExpression)
CAMBER_DESCRIBED(MetricOperation)
CAMBER_DESCRIBED(Surface)
CAMBER_DESCRIBED(Geometry)
CAMBER_DESCRIBED(Stage)
#undef CAMBER_KIND
#define CAMBER_KIND Wrapper
CAMBER_DESCRIBED(SizeExpression)
CAMBER_DESCRIBED(SizesExpression)
CAMBER_DESCRIBED(TensorExpression)
CAMBER_DESCRIBED(Intersect)
CAMBER_DESCRIBED(SizesMetric)
CAMBER_DESCRIBED(Analytic)
#undef CAMBER_KIND
#undef CAMBER_DESCRIBED

/// Makes the field of an option of S or of its base class.
template <class S, class B, class T>
[[nodiscard]] Field field(const Option<B, T>& option) {
    T S::* const member = option.member;
    const std::string name(option.name);
    return {member,        &codec_of<T>(),     name,  std::string(option.sentence), std::string(option.unit_name),
            option.limits, option.is_required, {name}};
}

/// Makes a required choice whose keys are in the object of the struct.
template <class S, class V>
[[nodiscard]] Field inlined(V S::* member) {
    const Choice& choice = Described<V>::get();
    std::string name;
    for (const std::string& key : choice.keys()) name += (name.empty() ? "" : " | ") + key;
    return {member, &choice, std::move(name), choice.doc, {}, {}, true, choice.keys(), &choice};
}

template <class S>
[[nodiscard]] std::vector<Field> listed() {
    std::vector<Field> fields;
    if constexpr (HasOptions<S>) each_option<S>([&](const auto& option) { fields.push_back(field<S>(option)); });
    return fields;
}

/// Describes a struct. `check` returns the error of a struct with valid fields, or an empty text.
template <class S>
[[nodiscard]] Description described(std::string name, std::string doc, std::vector<Field> fields,
                                    std::string (*check)(const S&) = nullptr) {
    Description description;
    description.name = std::move(name);
    description.doc = std::move(doc);
    description.fields = std::move(fields);
    description.defaults = [] { return written(S{}); };
    if (check != nullptr)
        description.check = [check](const void* value) { return check(*static_cast<const S*>(value)); };
    return description;
}
template <class S>
[[nodiscard]] Description described(std::string name, std::string doc, std::string (*check)(const S&) = nullptr) {
    return described<S>(std::move(name), std::move(doc), listed<S>(), check);
}

template <class T>
struct Key {
    std::string name, doc;
};
template <class T>
[[nodiscard]] Key<T> key(std::string name, std::string doc) {
    return {std::move(name), std::move(doc)};
}

template <class V, class... T>
[[nodiscard]] Choice choice_of(std::string name, std::string doc, Key<T>... keys) {
    static_assert(std::is_same_v<V, std::variant<T...>>, "one key for each alternative, in the variant's order");
    Choice choice;
    choice.name = std::move(name);
    choice.doc = std::move(doc);
    choice.alternatives = {{std::move(keys.name), std::move(keys.doc), &codec_of<T>(), [](void* variant) -> void* {
                                return &static_cast<V*>(variant)->template emplace<T>();
                            }}...};
    choice.alternative_of = [](const void* variant) {
        const V& v = *static_cast<const V*>(variant);
        return std::pair(v.index(), std::visit([](const auto& value) -> const void* { return &value; }, v));
    };
    return choice;
}

}  // namespace camber::config
