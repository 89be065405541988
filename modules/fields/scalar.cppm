module;
#include <functional>
#include <span>
#include <string>
export module camber.fields:scalar;
import camber.core;

/// Scalar fields written as expressions of the coordinates x, y and (3D) z, in muparser's notation: numbers,
/// + − * / ^, comparisons, && and ||, c ? a : b, pi, and functions as sqrt, exp, log (natural), sin, tanh, atan2, abs,
/// min, max.
export namespace camber {

/// An expression that can be read.
template <int D>
class ScalarExpression {
  public:
    /// Errors (usage): one that cannot be read, with the expression and the position in it.
    [[nodiscard]] static Outcome<ScalarExpression> parsed(std::string text);

    /// Its values at points, written into a span of the same size; NaN where there is none. With a state: each thread
    /// takes one of its own.
    [[nodiscard]] std::function<void(std::span<const Vec<D>>, std::span<double>)> evaluator() const;

    [[nodiscard]] const std::string& text() const { return text_; }

  private:
    explicit ScalarExpression(std::string text);
    std::string text_;
};

/// The expression "…", no longer than a message has place for.
[[nodiscard]] std::string quoted_expression(const std::string& text);

}  // namespace camber
