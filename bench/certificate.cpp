// Counts wrong and undecided results of `certify` and measures the time of each level. Elements on integer lattices are
// compared with 128-bit integers, elements in general position with integers of arbitrary length
// (tests/support/exact_oracle.hpp, which shares no code with the library). The program takes arguments and is not a
// timed test:
//
//     certificate --lattice 10000000 --general 100000 [--bound 0] [--threads 0] [--seed 1]
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <string_view>
#include <system_error>

import camber.core;
import camber.bezier;
import camber.validity;

#include "element_families.hpp"
#include "exact_oracle.hpp"

using namespace camber;
using oracle::Answer;

namespace {

struct Arguments {
    std::size_t lattice = 1000000, general = 10000;
    double bound = 0;
    int threads = 0;
    std::uint64_t seed = 1;
};

/// Counts of the results of one family of elements.
struct Tally {
    std::size_t elements = 0;
    std::array<std::size_t, 3> verdicts{};           // by Verdict
    std::size_t false_valid = 0, false_invalid = 0;  // the oracle proves the contrary
    std::size_t unproven = 0;                        // undecided by the oracle, without a witness
    std::size_t no_witness = 0, wrong_witness = 0;   // of the invalid elements
    std::array<std::size_t, levels> decided{};       // by Level
    std::array<double, levels> nanoseconds{};

    Tally& operator+=(const Tally& o) {
        elements += o.elements;
        for (std::size_t i = 0; i < verdicts.size(); ++i) verdicts[i] += o.verdicts[i];
        false_valid += o.false_valid;
        false_invalid += o.false_invalid;
        unproven += o.unproven;
        no_witness += o.no_witness;
        wrong_witness += o.wrong_witness;
        for (std::size_t i = 0; i < decided.size(); ++i) decided[i] += o.decided[i];
        for (std::size_t i = 0; i < decided.size(); ++i) nanoseconds[i] += o.nanoseconds[i];
        return *this;
    }
};

template <int D>
Certificate<D> timed(const NodalSimplex<D>& s, double bound, Tally& tally) {
    const auto begin = std::chrono::steady_clock::now();
    const auto certificate = certify(s, bound);
    const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - begin;
    const auto level = static_cast<std::size_t>(certificate.level);
    ++tally.elements;
    ++tally.verdicts[static_cast<std::size_t>(certificate.verdict)];
    ++tally.decided[level];
    tally.nanoseconds[level] += spent.count();
    return certificate;
}

/// Adds a result to the tally. `witness_fails` is true if the exact condition fails at the witness.
template <int D>
void compare(const Certificate<D>& certificate, Answer answer, bool witness_fails, Tally& tally) {
    const bool invalid = certificate.verdict == Verdict::invalid;
    tally.false_valid += certificate.verdict == Verdict::valid && answer == Answer::invalid;
    tally.false_invalid += invalid && answer == Answer::valid;
    tally.no_witness += invalid && !certificate.witness;
    tally.wrong_witness += certificate.witness && !witness_fails;
    tally.unproven += certificate.verdict != Verdict::undecided && answer == Answer::unknown && !witness_fails;
}

template <int D>
void try_lattice(families::Random& random, double bound, Tally& tally) {
    const auto n = families::lattice_element<D>(random, random() % 3 < 2 ? 1 : 2, 1 + random() % (2 * D));
    const auto s = families::in_doubles<D>(n);
    const auto certificate = timed(s, bound, tally);
    // Lattice elements are checked for bound 0 only: multiples of |det straight| would not fit into 128 bits.
    const Answer answer = oracle::answer<D, oracle::Wide, std::int64_t>(n, {}, {28, 10000, 24});
    const bool fails = certificate.witness && !oracle::holds_at<D>(s, *certificate.witness, 0);
    compare(certificate, answer, fails, tally);
}

template <int D>
void try_general(families::Random& random, families::Family family, double bound, Tally& tally) {
    auto s = families::element<D>(random, family);
    if (family == families::Family::tuned)
        s = families::tuned<D>(random, families::element<D>(random, static_cast<families::Family>(random() % 5)),
                               [&](const NodalSimplex<D>& x) { return decide(x, bound) == Verdict::valid; });
    const auto certificate = timed(s, bound, tally);
    const Answer answer = oracle::answer<D>(s, bound);
    const bool fails = certificate.witness && !oracle::holds_at<D>(s, *certificate.witness, bound);
    compare(certificate, answer, fails, tally);
}

/// Calls `one(random, tally)` `count` times in parallel. The random elements do not depend on the number of threads.
template <class One>
Tally repeat(const Arguments& arguments, std::size_t count, std::uint64_t stream, One&& one) {
    constexpr std::size_t grain = 1000;
    const std::size_t chunks = (count + grain - 1) / grain;
    const auto total = reduce_each(
        Execution{arguments.threads}, chunks, Tally{},
        [&](Tally& tally, std::size_t chunk) {
            std::seed_seq seeds{arguments.seed, stream, static_cast<std::uint64_t>(chunk)};
            families::Random random(seeds);
            const std::size_t end = std::min(count, (chunk + 1) * grain);
            for (std::size_t i = chunk * grain; i < end; ++i) one(random, tally);
        },
        [](Tally a, const Tally& b) { return a += b; }, 1);
    if (!total) std::fprintf(stderr, "%s\n", describe(total.error()).c_str());
    return total ? *total : Tally{};
}

void print(const std::string& family, const Tally& t) {
    std::printf("| %-18s | %9zu | %9zu | %9zu | %6zu | %5zu | %5zu | %6zu | %5zu |", family.c_str(), t.elements,
                t.verdicts[0], t.verdicts[1], t.verdicts[2], t.false_valid, t.false_invalid, t.unproven, t.no_witness);
    const double all = t.elements > 0 ? static_cast<double>(t.elements) : 1;
    for (std::size_t i = 0; i < levels; ++i) std::printf(" %7.3f |", 100 * static_cast<double>(t.decided[i]) / all);
    for (std::size_t i = 0; i < levels; ++i)
        if (t.decided[i] > 0)
            std::printf(" %6.2f |", 1e-3 * t.nanoseconds[i] / static_cast<double>(t.decided[i]));
        else
            std::printf("      - |");
    std::printf("\n");
    std::fflush(stdout);
}

void print_head() {
    std::printf(
        "share decided by each level in %%; time of one element by the level that decided it in µs\n\n"
        "| family             |  elements |     valid |   invalid | undec. | false | false | un-    | no    |"
        " filter  | bisect. | twice   | exact   | filter | bisec. | twice  | exact  |\n"
        "|                    |           |           |           |        | valid | inv.  | proven | witn. |"
        " %%       | %%       | %%       | %%       | µs     | µs     | µs     | µs     |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

template <class Number>
bool read(std::string_view text, Number& number) {
    const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
    return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

bool read(int count, char** words, Arguments& arguments) {
    for (int i = 1; i + 1 < count; i += 2) {
        const std::string_view name = words[i];
        const std::string_view value = words[i + 1];
        const bool known = name == "--lattice"   ? read(value, arguments.lattice)
                           : name == "--general" ? read(value, arguments.general)
                           : name == "--bound"   ? read(value, arguments.bound)
                           : name == "--threads" ? read(value, arguments.threads)
                           : name == "--seed"    ? read(value, arguments.seed)
                                                 : false;
        if (!known) return false;
    }
    return count % 2 == 1;
}

template <int D>
void run(const Arguments& arguments, Tally& total) {
    const std::string dimension = std::to_string(D) + "D";
    const auto show = [&](const std::string& name, const Tally& tally) {
        print(dimension + " " + name, tally);
        total += tally;
    };
    show("lattice", repeat(arguments, arguments.lattice / 2, 100 * D,
                           [&](auto& random, Tally& tally) { try_lattice<D>(random, 0, tally); }));
    for (int f = 0; f < families::count; ++f)
        show(families::names[static_cast<std::size_t>(f)],
             repeat(arguments, arguments.general / (2 * families::count), 100 * D + 1 + static_cast<std::uint64_t>(f),
                    [&](auto& random, Tally& tally) {
                        try_general<D>(random, static_cast<families::Family>(f), arguments.bound, tally);
                    }));
}

}  // namespace

/// Exit code: 0 if all results are correct, 1 if one is wrong, 2 for wrong arguments.
int main(int count, char** words) {
    Arguments arguments;
    if (!read(count, words, arguments)) {
        std::fprintf(
            stderr,
            "certificate [--lattice N] [--general M] [--bound B] [--threads T] [--seed S]: tries N elements on "
            "integer lattices and M in general position, half of them triangles\n");
        return 2;
    }
    print_head();
    Tally total;
    run<2>(arguments, total);
    run<3>(arguments, total);
    print("all", total);
    std::printf("\nwitnesses that do not fail: %zu\n", total.wrong_witness);
    return total.false_valid + total.false_invalid + total.wrong_witness == 0 ? 0 : 1;
}
