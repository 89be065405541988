// Writes the plate of plate.py as a CAD file. Usage: write_models FILE; the ending selects the format.
#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "models.hpp"

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    const std::filesystem::path path(argv[1]);
    try {
        const cad_tests::File file(path.extension().string());
        cad_tests::write_model(cad_tests::Kind::plate, {}, file);
        std::filesystem::copy_file(file.path(), path, std::filesystem::copy_options::overwrite_existing);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
