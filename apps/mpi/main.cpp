// The program on several MPI ranks, for example `mpirun -n 4 camber-mpi curve …`.
#include <cstddef>
#include <memory>

#include "program.hpp"
import camber.app_shell;
import camber.commands;
import camber.distributed;
import camber.mpi;

int main(int argc, char** argv) {
    camber::app::protect_standard_streams();
    return camber::app::with_usual_stack([&] {
        if (const auto code = camber::app::cad_reader({argv, static_cast<std::size_t>(argc)})) return *code;
        const std::shared_ptr<camber::Ranks> ranks = camber::mpi_ranks(argc, argv);
        return camber::app::run_program({argv, static_cast<std::size_t>(argc)}, ranks, camber::parts_of_graph);
    });
}
