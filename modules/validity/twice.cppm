export module camber.validity:twice;

export namespace camber {

/// A number as the unevaluated sum of two doubles (Dekker 1971): about 104 bits. Needs arithmetic that is not
/// contracted.
struct Twice {
    double high = 0, low = 0;

    constexpr Twice() = default;
    constexpr Twice(double x) : high(x) {}  // NOLINT(*-explicit-*): doubles are such numbers
    constexpr Twice(double h, double l) : high(h), low(l) {}

    /// a + b, exactly (Knuth).
    [[nodiscard]] static constexpr Twice sum(double a, double b) {
        const double s = a + b;
        const double t = s - a;
        return {s, (a - (s - t)) + (b - t)};
    }
    /// The same for |a| ≥ |b|.
    [[nodiscard]] static constexpr Twice quick_sum(double a, double b) {
        const double s = a + b;
        return {s, b - (s - a)};
    }
    /// a · b, exactly but for underflow (Veltkamp, Dekker).
    [[nodiscard]] static constexpr Twice product(double a, double b) {
        const Twice x = halves(a);
        const Twice y = halves(b);
        const double p = a * b;
        return {p, ((x.high * y.high - p) + x.high * y.low + x.low * y.high) + x.low * y.low};
    }

    friend constexpr Twice operator+(const Twice& a, const Twice& b) {
        const Twice s = sum(a.high, b.high);
        const Twice t = sum(a.low, b.low);
        const Twice u = quick_sum(s.high, s.low + t.high);
        return quick_sum(u.high, u.low + t.low);
    }
    friend constexpr Twice operator-(const Twice& a) { return {-a.high, -a.low}; }
    friend constexpr Twice operator-(const Twice& a, const Twice& b) { return a + -b; }
    friend constexpr Twice operator*(const Twice& a, const Twice& b) {
        const Twice p = product(a.high, b.high);
        return quick_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
    }
    constexpr Twice& operator+=(const Twice& o) { return *this = *this + o; }
    friend constexpr bool operator<(const Twice& a, const Twice& b) {
        return a.high < b.high || (a.high == b.high && a.low < b.low);
    }
    friend constexpr bool operator>(const Twice& a, const Twice& b) { return b < a; }

  private:
    /// x as a sum of two numbers of 26 bits.
    [[nodiscard]] static constexpr Twice halves(double x) {
        const double c = 134217729.0 * x;  // 2²⁷ + 1
        const double h = c - (c - x);
        return {h, x - h};
    }
};

}  // namespace camber
