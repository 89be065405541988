"""Checks that each source file includes the standard headers of the names that it uses. If the standard library is one
header module (cmake/HeaderModule.cmake), the compiler does not report missing headers, and a build without the module
fails.

    python3 tests/includes/check_includes.py [FILE…]        all sources of the project without FILE; exit code 1: something is missing

A header counts if the file includes it directly or through a project header ("…"). Names are searched in the text, so that calls in
templates count too. A standard name that the table does not contain is an error.
"""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# header: its names. A name with several headers needs any of them.
TABLE = """
algorithm: adjacent_find all_of any_of binary_search clamp copy copy_n count copy_if count_if fill find inplace_merge find_if is_sorted lower_bound make_heap pop_heap push_heap max
    max_element min min_element minmax minmax_element next_permutation none_of nth_element partial_sort remove_if reverse shuffle
    sort stable_sort swap_ranges transform unique upper_bound equal_range for_each rotate merge is_permutation equal fill_n replace
    ranges::adjacent_find ranges::all_of ranges::any_of ranges::binary_search ranges::copy ranges::count ranges::count_if
    ranges::equal ranges::equal_range ranges::fill ranges::find ranges::find_if ranges::for_each ranges::inplace_merge ranges::is_sorted ranges::lower_bound ranges::max
    ranges::includes ranges::max_element ranges::merge ranges::min ranges::min_element ranges::minmax ranges::move ranges::none_of ranges::nth_element ranges::partial_sort ranges::pop_heap ranges::push_heap ranges::replace ranges::reverse ranges::set_difference ranges::sort ranges::stable_sort
    ranges::transform ranges::unique ranges::upper_bound
array: array to_array
atomic: atomic atomic_flag atomic_ref atomic_thread_fence memory_order_acq_rel memory_order_acquire memory_order_relaxed
    memory_order_release memory_order_seq_cst
barrier: barrier
bit: bit_cast bit_ceil bit_floor bit_width countl_zero countr_zero endian has_single_bit popcount
cctype: isalnum isalpha isdigit isspace tolower toupper
charconv: chars_format from_chars from_chars_result to_chars to_chars_result
chrono: chrono chrono_literals
cmath: abs acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs floor fma fmax fmin fmod
    frexp hypot ilogb isfinite isinf isnan ldexp lerp lgamma llround log log10 log1p log2 logb lround modf nan nearbyint nextafter
    pow remainder rint round scalbn signbit sin sinh sqrt tan tanh tgamma trunc
compare: partial_ordering strong_ordering weak_ordering
concepts: convertible_to default_initializable derived_from equality_comparable floating_point integral invocable same_as signed_integral unsigned_integral
csignal: raise sig_atomic_t signal
cstddef: byte max_align_t nullptr_t ptrdiff_t size_t
cstdint: int16_t int32_t int64_t int8_t intptr_t uint16_t uint32_t uint64_t uint8_t uintptr_t uintmax_t intmax_t
cstdio: FILE fclose fflush fgets fopen fprintf fputc fputs fread fwrite perror printf puts remove rename size_t snprintf
cstdlib: abort aligned_alloc atexit exit free getenv malloc quick_exit size_t strtod system
cstring: memchr memcmp memcpy memmove memset size_t strchr strcmp strerror strlen strncmp strrchr strstr
ctime: clock clock_t
deque: deque
exception: current_exception exception exception_ptr rethrow_exception terminate
filesystem: filesystem
fstream: fstream ifstream ofstream
functional: bind_front function greater greater_equal hash identity invoke less less_equal mem_fn minus multiplies negate plus ref
    reference_wrapper cref
initializer_list: initializer_list
iomanip: quoted setfill setprecision setw
ios: fixed hex ios ios_base scientific streamoff streamsize
istream: getline istream ws
iterator: advance back_insert_iterator back_inserter distance forward_iterator_tag input_iterator istream_iterator
    istreambuf_iterator iterator_traits make_move_iterator next ostream_iterator prev random_access_iterator_tag size ssize
    reverse_iterator data begin end
limits: numeric_limits
list: list
map: map multimap
memory: addressof allocator allocator_traits construct_at destroy_at make_shared make_unique shared_ptr to_address unique_ptr
    weak_ptr
memory_resource: pmr
condition_variable: condition_variable cv_status
mutex: call_once lock_guard mutex once_flag scoped_lock try_to_lock unique_lock
new: align_val_t bad_alloc bad_array_new_length hardware_destructive_interference_size launder nothrow set_new_handler
numbers: numbers
numeric: accumulate exclusive_scan gcd inclusive_scan inner_product iota lcm midpoint partial_sum reduce
optional: make_optional nullopt nullopt_t optional
ostream: endl flush ostream
queue: priority_queue queue
random: bernoulli_distribution mt19937 mt19937_64 normal_distribution random_device seed_seq uniform_int_distribution
    uniform_real_distribution
ranges: ranges::subrange ranges::views views
ratio: milli micro nano ratio
set: multiset set
span: as_bytes as_writable_bytes dynamic_extent span
iostream: cerr cin cout clog
streambuf: streambuf
sstream: istringstream ostringstream stringstream
stdexcept: invalid_argument length_error logic_error out_of_range overflow_error runtime_error
stop_token: stop_callback stop_source stop_token
string: char_traits getline stod stoi stol stoll stoul stoull string to_string u8string
string_view: string_view
system_error: errc error_code generic_category make_error_code system_category system_error
thread: jthread this_thread thread
tuple: apply forward_as_tuple get ignore make_tuple tie tuple tuple_cat tuple_element_t tuple_size tuple_size_v
type_traits: bool_constant common_type_t conditional_t decay_t enable_if_t false_type integral_constant invoke_result_t
    is_arithmetic_v is_base_of_v is_assignable_v is_constant_evaluated is_constructible_v is_convertible_v is_copy_constructible_v is_default_constructible_v
    is_enum_v is_floating_point_v is_integral_v is_invocable_r_v is_invocable_v is_lvalue_reference_v is_nothrow_move_constructible_v is_same_v
    is_signed_v is_trivially_copyable_v is_unsigned_v is_void_v make_signed_t make_unsigned_t remove_const_t remove_cvref_t remove_pointer_t
    remove_reference_t true_type type_identity type_identity_t underlying_type_t void_t
typeinfo: bad_cast type_info
unordered_map: unordered_map unordered_multimap
unordered_set: unordered_multiset unordered_set
utility: as_const cmp_equal cmp_greater cmp_less cmp_less_equal declval exchange forward get in_place in_place_index in_place_type in_range
    index_sequence integer_sequence make_index_sequence make_integer_sequence make_pair move move_if_noexcept pair swap to_underlying
    unreachable
array: get swap
variant: bad_variant_access get get_if holds_alternative monostate variant variant_alternative_t variant_npos variant_size
    variant_size_v visit in_place_index in_place_type
vector: erase erase_if vector
map: erase_if
set: erase_if
string: erase erase_if size
span: size
chrono: micro milli nano
fstream: ios
sstream: ios
vector: size begin end
array: size begin end data
"""
# Macros and names of C without std::.
PLAIN = {
    "cerrno": r"errno|E(?:ACCES|AGAIN|BADF|CANCELED|DQUOT|EXIST|FBIG|INTR|INVAL|ISDIR|NOENT|NOMEM|NOSPC|NOTDIR|NXIO|OPNOTSUPP|PERM|PIPE|ROFS)",
    "csignal": r"SIG(?:INT|TERM|PIPE|XFSZ|SEGV|ABRT|_IGN|_DFL)",
    "cstdio": r"stderr|stdout|stdin|EOF",
    "climits": r"CHAR_BIT|(?:U?INT|U?LONG|U?LLONG)_MAX|PATH_MAX|NAME_MAX",
    "cmath": r"INFINITY|NAN|HUGE_VAL",
    "cstdlib": r"EXIT_(?:SUCCESS|FAILURE)",
}
NESTED = {"ranges"}  # namespaces whose members come from several headers
ALSO = {"cerrno": {"errno.h"}, "csignal": {"signal.h"}, "climits": {"limits.h"}}


# The ends of an edge are an array: a structured binding needs std::get.
ENDS = re.compile(r"auto\s*&?\s*\[\w+, \w+\] = [^;{]*?\b(?:vertices|local_edges<\w+>)\[")


def headers_by_name():
    table = {}
    for entry in re.split(r"\n(?=\S)", TABLE.strip()):
        header, names = entry.split(":", 1)
        for name in names.split():
            table.setdefault(name, set()).add(header)
    return table


HEADERS = headers_by_name()
# Comments and literals, except for names of included files.
NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'', re.S)
NAME = re.compile(r"\bstd::(\w+)(?:::(\w+))?")


def included(path, visited=None):
    """The standard headers that a file includes directly or through project headers."""
    visited = set() if visited is None else visited
    if path in visited:
        return set()
    visited.add(path)
    text = path.read_text()
    found = set(re.findall(r"^#include <([\w./]+)>", text, re.M))
    for header_name in re.findall(r'^#include "([\w./]+)"', text, re.M):
        for folder in (path.parent, ROOT / "tests" / "support"):
            if (folder / header_name).exists():
                found |= included(folder / header_name, visited)
                break
    return found


def missing(path):
    """[(line, name, possible headers)] of the first use of each name without its header."""
    text = NOISE.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), path.read_text())
    there = included(path)
    found = {}
    for match in NAME.finditer(text):
        first, second = match.groups()
        name = f"{first}::{second}" if first in NESTED and second else first
        needed = HEADERS.get(name)
        if needed is None or not needed & there:
            found.setdefault(f"std::{name}", (match.start(), needed or set()))
    for header, names in PLAIN.items():
        match = re.search(rf"(?<!::)(?<!\w)(?:{names})\b(?!::)", text)
        if match and not ({header} | ALSO.get(header, set())) & there:
            found.setdefault(match[0], (match.start(), {header}))
    match = ENDS.search(text)
    if match and "array" not in there:
        found["a structured binding of ends"] = (match.start(), {"array"})
    return sorted((text.count("\n", 0, at) + 1, name, needed) for name, (at, needed) in found.items())


def main(arguments):
    files = [Path(a).resolve() for a in arguments] or sorted(
        p for folder in ("modules", "apps", "tests", "bench") for p in (ROOT / folder).rglob("*")
        if p.suffix in (".cpp", ".cppm", ".hpp"))
    bad = 0
    for path in files:
        for line, name, needed in missing(path):
            bad += 1
            what = f"needs #include <{'> or <'.join(sorted(needed))}>" if needed else "is not in the table of " + __file__
            print(f"{path.relative_to(ROOT) if path.is_relative_to(ROOT) else path}:{line}: {name} {what}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
