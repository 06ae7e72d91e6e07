// Writes an HDF5 file with columns of every type, for the test: hdf5-tables FILE ROWS.
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/text/files/table_file.hpp>

using namespace momentree;
using namespace momentree::io;

namespace {

// The check computes the same values.
void write(const std::string& path, std::size_t rows) {
  using Type = TableColumn::Type;
  const std::unique_ptr<TableFile> file = make_hdf5_file(path);
  const std::size_t table = file->add_table("worlds", {{"world", Type::count},
                                                       {"arm/elbow.q0", Type::number, "rad", "angle of the elbow"},
                                                       {"caught", Type::flag},
                                                       {"status", Type::text},
                                                       {"a//b", Type::number},
                                                       {"world/x", Type::number}});
  const std::size_t empty = file->add_table("empty", {{"none", Type::number}});
  file->file_attribute("title", std::string("Größe"));
  file->file_attribute("seed", std::uint64_t{0x8000000000000001});
  file->attribute(table, "mean", 0.1);
  file->attribute(empty, "names", std::vector<std::string>{"a", "b/c"});
  for (std::size_t done = 0, part = 1; done < rows; done += part, ++part) {
    part = std::min(part, rows - done);
    std::vector<std::uint64_t> worlds;
    std::vector<double> angles, others;
    std::vector<std::uint8_t> flags;
    std::vector<std::string> texts;
    for (std::size_t i = done; i < done + part; ++i) {
      worlds.push_back(i == 0 ? ~std::uint64_t{0} : i);
      angles.push_back(i % 7 == 3 ? std::nan("") : static_cast<double>(i) / 3);
      others.push_back(-static_cast<double>(i));
      flags.push_back(i % 3 == 0);
      texts.push_back(i % 5 == 0 ? "" : "zerstört " + std::to_string(i));
    }
    file->append(table, std::vector<ColumnValues>{worlds, angles, flags, texts, others, others});
  }
  file->finish();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    write(argv[1], std::strtoull(argv[2], nullptr, 10));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << std::endl;
    return 1;
  }
}
