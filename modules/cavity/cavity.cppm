/// The P2 cavity operator: a cavity emptied and starred, its edges curved, its elements validated and repaired, and
/// what comes of it committed; of one vertex, and of all in turns.
export module camber.cavity;
export import :star;
export import :patch;
export import :reinsert;
export import :commit;
export import :reinsert_all;
import :attempt;
