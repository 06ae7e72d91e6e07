#include <cli/commit.hpp>
#include <cli/program.hpp>

int main(int argc, char** argv) { return momentree::cli::program(argc, argv, momentree::cli::bench, momentree::cli::commit); }
