#include <cli/commands/sweep_hdf5.hpp>

#include <cmath>
#include <filesystem>
#include <utility>

#include <momentree/base/error.hpp>
#include <momentree/text/json.hpp>

namespace momentree::cli {

namespace {
constexpr std::size_t rows_at_once = 4096;
}

SweepTable::SweepTable(const sweep::Sweep& sweep, const std::string& path) : sweep_(sweep), varied_(parameter_columns(sweep)) {
  using Type = io::TableColumn::Type;
  columns_ = {{"world", Type::count, "", "number of the world"}};
  for (const sweep::ParameterColumn& column : varied_) {
    const sweep::Parameter& parameter = sweep_.parameters[column.parameter];
    columns_.push_back({column.name, column.is_text ? Type::text : Type::number, parameter.unit, parameter.about});
  }
  for (const sweep::Measure& measure : sweep_.measures)
    columns_.push_back({measure.name, measure.is_flag() ? Type::flag : Type::number, measure.unit, measure.about});
  columns_.push_back({"status", Type::text, "", "done, or failed and why"});
  file_ = io::make_hdf5_file(path);
  worlds_ = file_->add_table("worlds", columns_);
  outcome_ = file_->add_table("outcome", {{"done", Type::flag, "", "the world has measures: it did not fail"}});
  clear();
}

void SweepTable::clear() {
  using Type = io::TableColumn::Type;
  values_.clear();
  done_.clear();
  for (const io::TableColumn& column : columns_) {
    if (column.type == Type::number) values_.emplace_back(std::vector<double>());
    if (column.type == Type::flag) values_.emplace_back(std::vector<std::uint8_t>());
    if (column.type == Type::text) values_.emplace_back(std::vector<std::string>());
    if (column.type == Type::count) values_.emplace_back(std::vector<std::uint64_t>());
  }
}

void SweepTable::write() {
  if (done_.empty()) return;
  file_->append(worlds_, values_);
  const io::ColumnValues done = std::move(done_);
  file_->append(outcome_, {&done, 1});
  clear();
}

void SweepTable::add(const sweep::Row& row) {
  std::size_t c = 0;
  std::get<std::vector<std::uint64_t>>(values_[c++]).push_back(row.world);
  for (const sweep::ParameterColumn& column : varied_) {
    io::ColumnValues& cells = values_[c++];
    if (column.is_text)
      std::get<std::vector<std::string>>(cells).push_back(parameter_text(column, row.values));
    else
      std::get<std::vector<double>>(cells).push_back(parameter_number(column, row.values));
  }
  for (std::size_t m = 0; m < sweep_.measures.size(); ++m) {
    const double x = row.result.done() ? row.result.measures[m] : NAN;
    io::ColumnValues& cells = values_[c++];
    if (sweep_.measures[m].is_flag())
      std::get<std::vector<std::uint8_t>>(cells).push_back(x == 1 ? 1 : 0);  // of a failed world: false; see outcome/done
    else
      std::get<std::vector<double>>(cells).push_back(x);
  }
  std::get<std::vector<std::string>>(values_[c]).push_back(status_of(row.result));
  done_.push_back(row.result.done() ? 1 : 0);
  if (done_.size() == rows_at_once) write();
}

void SweepTable::finish(const std::string& summary) {
  write();
  file_->file_attribute("summary", summary);
  file_->finish();
}

std::string summary_in(const std::string& path) {
  const std::string text = io::hdf5_text(path, "summary").value_or("");
  try {
    const Value document = io::parse_json(text, path);
    const Value::Entry* const program = document.find("program");
    const Value::Entry* const name = program != nullptr ? program->value.find("name") : nullptr;
    if (name != nullptr && name->value.string() && *name->value.string() == "momentree") return text;
  } catch (const Error&) {  // not a document
  }
  return "";
}

void require_replaceable(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::symlink_status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) return;
  if (std::filesystem::is_regular_file(status) && !summary_in(path).empty()) return;
  throw_error(
      {"this is not the result of a sweep, and would be replaced", path, "move it elsewhere, or name another file with --out"});
}

}  // namespace momentree::cli
