#include <momentree/results/columns/contact_columns.hpp>

#include <charconv>
#include <limits>

#include <momentree/base/error.hpp>
#include <momentree/results/recording/number_table.hpp>
#include <momentree/text/files/line_reader.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

double number_of_cell(const std::string& cell, const std::string& where) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0;
  const char* const end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  if (error != std::errc{} || stop != end)
    throw_error({"'" + cell + "' is not a number", where, "the file was truncated or modified: run again"});
  return value;
}

}  // namespace

void contact_header(std::string& text) {
  text += "time,one,other";
  for (const char* what : {"point", "normal", "force"})
    for (const char* axis : {".x", ".y", ".z"}) text += std::string(",") + what + axis;
  text += ",slip\n";
}

void contact_rows(std::string& text, const World& world) {
  const auto name = [&](BodyId body) { return world.model().body_name(body); };
  for (const ContactPoint& contact : world.contacts()) {
    append_number(text, world.time());
    text += ',' + name(contact.one) + ',' + name(contact.other);
    for (const Vec3* v : {&contact.point, &contact.normal, &contact.force})
      for (const double x : {v->x, v->y, v->z}) text += ',', append_number(text, x);
    text += ',', append_number(text, norm(contact.slip));
    text += '\n';
  }
}

void for_each_contact(const std::filesystem::path& file, const std::function<void(const ContactCells&)>& visit) {
  constexpr std::size_t first = 3;  // column of numbers
  std::string header;
  contact_header(header);
  header.pop_back();  // its line end
  LineReader in(file);
  std::string line;
  if (!in.next(line) || line != header) throw_error({"the columns are not those of contacts", file.string() + ":1", "run again"});
  ContactCells row;
  while (in.next(line) && in.is_whole()) {
    const std::string where = file.string() + ':' + std::to_string(in.number());
    const std::vector<std::string> cells = split_csv(line);
    if (cells.size() != first + row.numbers.size())
      throw_error(
          {"the row has " + std::to_string(cells.size()) + " columns", where, "the file was truncated or modified: run again"});
    row.time = number_of_cell(cells[0], where), row.one = cells[1], row.other = cells[2];
    for (std::size_t i = 0; i < row.numbers.size(); ++i) row.numbers[i] = number_of_cell(cells[first + i], where);
    visit(row);
  }
}

}  // namespace momentree::io
