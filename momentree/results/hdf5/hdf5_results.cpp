#include <momentree/results/hdf5/hdf5_results.hpp>

#include <momentree/results/columns/contact_columns.hpp>
#include <momentree/results/columns/result_column.hpp>
#include <momentree/results/recording/number_table.hpp>
#include <momentree/text/files/system_file.hpp>
#include <momentree/text/files/table_file.hpp>

namespace momentree::io {

namespace {

// Contacts have rows as they come, with the names of bodies.
void add_contacts(const std::filesystem::path& csv, TableFile& file) {
  std::vector<TableColumn> columns = {{.name = "time", .unit = "s"},
                                      {.name = "one", .type = TableColumn::Type::text, .about = "body on which the force acts"},
                                      {.name = "other", .type = TableColumn::Type::text, .about = "body that exerts it"}};
  for (std::size_t i = 0; i < contact_column_names.size(); ++i)
    columns.push_back({.name = contact_column_names[i], .unit = contact_column_units[i]});
  const std::size_t table = file.add_table("contacts", std::move(columns));
  std::vector<ColumnValues> values;
  std::size_t count = 0;
  const auto renew = [&] {
    values.assign(3 + contact_column_names.size(), std::vector<double>());
    values[1] = values[2] = std::vector<std::string>();
    count = 0;
  };
  const auto write = [&] {
    if (count > 0) file.append(table, values);
    renew();
  };
  renew();
  constexpr std::size_t at_once = 4096;
  for_each_contact(csv, [&](const ContactCells& row) {
    std::get<std::vector<double>>(values[0]).push_back(row.time);
    std::get<std::vector<std::string>>(values[1]).push_back(row.one);
    std::get<std::vector<std::string>>(values[2]).push_back(row.other);
    for (std::size_t i = 0; i < row.numbers.size(); ++i) std::get<std::vector<double>>(values[3 + i]).push_back(row.numbers[i]);
    if (++count == at_once) write();
  });
  write();
}

}  // namespace

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
  if (const std::filesystem::path csv = folder / "contacts.csv"; is_there(csv)) add_contacts(csv, *file);
  file->finish(to_disk);
}

}  // namespace momentree::io
