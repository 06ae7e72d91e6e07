#include <momentree/io/hdf5_results.hpp>

#include <momentree/io/picture/number_table.hpp>
#include <momentree/io/result_column.hpp>
#include <momentree/io/system_file.hpp>
#include <momentree/io/table_file.hpp>

namespace momentree::io {

void write_hdf5_results(const std::filesystem::path& folder, const RunOrigin& origin, const World& world,
                        const std::vector<JointKinds>& joints, bool to_disk) {
  const std::unique_ptr<TableFile> file = make_hdf5_file((folder / "results.h5").string());
  file->file_attribute("momentree", std::string(MOMENTREE_VERSION));
  if (!origin.title.empty()) file->file_attribute("title", origin.title);
  file->file_attribute("scenario", origin.file);
  file->file_attribute("scenario_hash", origin.hash);
  for (const std::string name : {"bodies", "joints", "energy", "springs"}) {
    const std::filesystem::path csv = folder / (name + ".csv");
    if (!is_there(csv)) continue;
    const NumberTable table(csv);
    std::vector<TableColumn> columns = {{.name = "time", .unit = "s"}};
    for (const std::string& column : table.columns()) {
      Diagnostic ignored;
      const auto known = ResultColumn::find(column, world, name == "joints" ? joints : std::vector<JointKinds>(), ignored);
      columns.push_back({.name = column, .unit = known ? known->unit() : ""});
    }
    const std::size_t number = file->add_table(name, std::move(columns));
    table.each_row([&](std::span<const double> row) { file->append_row(number, row); });
  }
  file->finish(to_disk);
}

}  // namespace momentree::io
