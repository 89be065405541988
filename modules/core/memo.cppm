module;
#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
export module camber.core:memo;
import :sparse;

export namespace camber {

/// The values of a pure function that were asked for: each is made at the first question, by whichever thread asks.
/// From several threads; copies share what is known.
template <class Key, class T>
class Memo {
  public:
    explicit Memo(std::function<T(Key)> make) : make_(std::move(make)), shards_(std::make_shared<Shards>()) {}

    [[nodiscard]] T operator[](Key key) const {
        Shard& shard = (*shards_)[key.index() % shards];
        {
            const std::scoped_lock lock(shard.mutex);
            if (const T* known = shard.values.find(key)) return *known;
        }
        // Not under the lock: two threads may both make it, and make the same.
        T value = make_(key);
        const std::scoped_lock lock(shard.mutex);
        shard.values.at(key) = value;
        return value;
    }

  private:
    static constexpr std::size_t shards = 64;
    struct Shard {
        std::mutex mutex;
        SparseMap<Key, T> values;
    };
    using Shards = std::array<Shard, shards>;

    std::function<T(Key)> make_;
    std::shared_ptr<Shards> shards_;
};

}  // namespace camber
