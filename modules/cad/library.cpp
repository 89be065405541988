module;
#include <dlfcn.h>

#include <array>
#include <memory>
#include <string>
#include <utility>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import :parts;

namespace camber {

#ifdef CAMBER_OCC_BUILT

namespace {

struct Library {
    occ::Open* open = nullptr;
    occ::Restore* restore = nullptr;
    std::string missing;  ///< why it cannot be used
};

Library loaded() {
    Library library;
    // Where it was installed with the program, which may have moved; else where it was built, or was meant to be
    // installed.
    for (const char* const name :
         {"$ORIGIN/../" CAMBER_OCC_BESIDE, "$ORIGIN/" CAMBER_OCC_FILE, CAMBER_OCC_BUILT, CAMBER_OCC_INSTALLED}) {
        void* const handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
        if (handle == nullptr) {
            const char* const said = dlerror();
            const std::string why = said != nullptr ? said : "no such library";
            // A place where it is not says nothing; what it lacks where it is, does.
            if (why.starts_with(name) && why.ends_with("No such file or directory")) continue;
            library.missing += (library.missing.empty() ? "" : "; ") + why;
            continue;
        }
        library.open = reinterpret_cast<occ::Open*>(dlsym(handle, "camber_occ_open"));
        library.restore = reinterpret_cast<occ::Restore*>(dlsym(handle, "camber_occ_restore"));
        if (library.open != nullptr && library.restore != nullptr) break;
        library.open = nullptr;
        library.missing = std::string(name) + " is not of this version of Camber";
    }
    if (library.open == nullptr && library.missing.empty()) library.missing = CAMBER_OCC_BESIDE " is not there";
    return library;
}

/// The kernel that `open(library, opened)` makes; errors name `path`.
template <class Open>
Outcome<std::unique_ptr<const occ::Kernel>> kernel_by(const std::string& path, Open&& open) {
    static const Library library = loaded();
    if (library.open == nullptr)
        return fail(ErrorKind::unsupported, "OpenCASCADE cannot be loaded: " + library.missing, path, {},
                    "install Camber's package camber-cad, or Debian's libocct-data-exchange-7.6, or take another "
                    "geometry");
    occ::Opened opened;
    open(library, opened);
    if (opened.is_out_of_memory)
        return fail(ErrorKind::memory, "not enough memory to read the model", path, {}, "give it more memory");
    if (!opened.kernel) return fail(ErrorKind::input, opened.fault, path, {}, opened.remedy);
    return std::unique_ptr<const occ::Kernel>(std::move(opened.kernel));
}

}  // namespace

bool knows_cad() { return true; }

Outcome<std::unique_ptr<const occ::Kernel>> open_kernel(const std::string& path, occ::Format format,
                                                        double millimetres) {
    return kernel_by(path, [&](const Library& library, occ::Opened& opened) {
        library.open(path.c_str(), format, millimetres, opened);
    });
}

Outcome<std::unique_ptr<const occ::Kernel>> restored_kernel(const std::string& bytes, double millimetres) {
    return kernel_by({},
                     [&](const Library& library, occ::Opened& opened) { library.restore(bytes, millimetres, opened); });
}

#else

bool knows_cad() { return false; }

Outcome<std::unique_ptr<const occ::Kernel>> open_kernel(const std::string& path, occ::Format, double) {
    return fail(ErrorKind::unsupported, "this build of Camber reads no CAD files", path, {},
                "install OpenCASCADE (Debian: libocct-data-exchange-dev) and build again, or take another geometry");
}

Outcome<std::unique_ptr<const occ::Kernel>> restored_kernel(const std::string&, double millimetres) {
    return open_kernel({}, {}, millimetres);
}

#endif

}  // namespace camber
