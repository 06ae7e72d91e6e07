#include <momentree/results/report/contact_rows.hpp>

#include <charconv>

#include <momentree/base/error.hpp>
#include <momentree/results/recording/number_table.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {

std::vector<ContactRow> read_contact_rows(const std::filesystem::path& file) {
  const std::string text = read_text_file(file.string(), Links::refuse);
  std::vector<ContactRow> rows;
  std::size_t line = 0;
  for (std::size_t at = 0, end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    if (++line == 1) continue;  // the header
    const std::vector<std::string> cells = split_csv(text.substr(at, end - at));
    const auto wrong = [&](const std::string& what) { throw_error({what, file.string() + ':' + std::to_string(line), ""}); };
    ContactRow row;
    if (cells.size() != row.numbers.size() + 3)
      wrong("a row of contacts has " + std::to_string(row.numbers.size() + 3) + " cells");
    const auto number = [&](const std::string& cell) {
      double x = 0;
      const auto [stop, problem] = std::from_chars(cell.data(), cell.data() + cell.size(), x);
      if (problem != std::errc() || stop != cell.data() + cell.size()) wrong("'" + cell + "' is not a number");
      return x;
    };
    row.time = number(cells[0]), row.one = cells[1], row.other = cells[2];
    for (std::size_t k = 0; k < row.numbers.size(); ++k) row.numbers[k] = number(cells[k + 3]);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace momentree::io
