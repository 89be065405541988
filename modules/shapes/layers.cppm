module;
#include <cstdint>
#include <tuple>
#include <vector>
export module camber.shapes:layers;
import camber.core;

export namespace camber {

/// Thin layers along a wall: heights first_height, first_height × growth, ….
struct BoundaryLayer {
    int count = 0;               ///< layers; 0 for none
    double first_height = 0.02;  ///< height of the layer at the wall (model units)
    double growth = 1.25;        ///< each layer's height over that of the one nearer to the wall
    Reference material = 1;      ///< of the layers' elements; what is not layers has 1
    Reference interface = 9;     ///< of the facets between the layers and what is above, if that is another material

    [[nodiscard]] static constexpr auto options() {
        using S = BoundaryLayer;
        return std::tuple(
            option("count", &S::count, "number of layers; 0 for none").at_least(0).at_most(1000),
            option("first_height", &S::first_height, "height of the layer at the wall").unit("model units").above(0),
            option("growth", &S::growth, "height of a layer over that of the one nearer to the wall").above(0),
            option("material", &S::material, "reference of the layers' elements; that of the others is 1"),
            option("interface", &S::interface,
                   "reference of the facets between the layers and the others, where their materials differ"));
    }
    friend bool operator==(const BoundaryLayer&, const BoundaryLayer&) = default;
};

/// Distances from the wall of the layers' outer sides, in rising order.
[[nodiscard]] inline std::vector<double> layer_distances(const BoundaryLayer& layer) {
    std::vector<double> distances;
    double height = layer.first_height, total = 0;
    for (int k = 0; k < layer.count; ++k, height *= layer.growth) distances.push_back(total += height);
    return distances;
}

/// Height of all layers together (model units).
[[nodiscard]] inline double thickness(const BoundaryLayer& layer) {
    return layer.count > 0 ? layer_distances(layer).back() : 0.0;
}

}  // namespace camber
