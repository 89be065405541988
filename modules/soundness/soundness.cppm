/// Whether a straight mesh is fit to work on: what may be wrong with it (`examine`), and what of it can be
/// mended without a doubt (`prepare`).
export module camber.soundness;
export import :defects;
export import :prepare;
export import :mean_ratio;
import :examination;
