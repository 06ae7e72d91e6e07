#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include <momentree/base/error.hpp>
#include <momentree/results/compare/parts.hpp>
#include <momentree/results/recording/number_table.hpp>
#include <momentree/text/diagnostic.hpp>
#include <momentree/text/files/line_reader.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

constexpr std::string_view contacts_file = "contacts.csv";

std::optional<double> number_of(std::string_view cell) {
  double value = 0;
  const char* const end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  return error == std::errc{} && stop == end ? std::optional(value) : std::nullopt;
}

// Reads on to the end, and counts the rows.
std::size_t rest_of(RowReader& in) {
  std::size_t count = 0;
  while (in.next()) ++count;
  return count;
}

struct NamedColumn {
  std::string name, column;
};
NamedColumn parts_of(const std::string& column) {
  const std::size_t dot = column.rfind('.');
  if (dot == std::string::npos) return {column, ""};
  return {column.substr(0, dot), column.substr(dot + 1)};
}

// The first column that only one of the tables has.
std::optional<Difference> other_columns(const RowReader& one, const RowReader& other, const char* file, const char* thing) {
  if (one.columns() == other.columns()) return std::nullopt;
  const auto lone = [](const RowReader& a, const RowReader& b) -> const std::string* {
    std::vector<std::string> known = b.columns();
    std::ranges::sort(known);
    for (const std::string& column : a.columns())
      if (!std::ranges::binary_search(known, column)) return &column;
    return nullptr;
  };
  Difference found{.kind = Difference::Kind::model, .file = file};
  const std::string *in_one = lone(one, other), *in_other = lone(other, one);
  if (const std::string* const column = in_one != nullptr ? in_one : in_other) {
    const NamedColumn parts = parts_of(*column);
    found.name = parts.name, found.column = parts.column;
    found.what = "only the " + std::string(in_one != nullptr ? "first" : "second") + " run has the column " + parts.column +
                 " of " + thing + ' ' + in_quotes(parts.name);
  } else {
    found.what = "the columns are in another order";
  }
  return found;
}

}  // namespace

bool near_enough(double one, double other, double tolerance) {
  return one == other || (std::isnan(one) && std::isnan(other)) ||
         std::fabs(one - other) <= tolerance * std::max({1.0, std::fabs(one), std::fabs(other)});
}

namespace {

// The first cell in which two rows of equal times differ.
std::optional<Difference> other_cell(const RowReader& one, const RowReader& other, const char* file, const char* thing,
                                     double tolerance) {
  const std::vector<std::string> a = split_csv(one.line()), b = split_csv(other.line());
  const auto& columns = one.columns();
  for (std::size_t i = 1; i < std::max(a.size(), b.size()); ++i) {
    const std::string x = i < a.size() ? a[i] : "", y = i < b.size() ? b[i] : "";
    if (x == y) continue;
    const std::optional<double> p = number_of(x), q = number_of(y);
    if (p && q && near_enough(*p, *q, tolerance)) continue;
    const std::string column = i < columns.size() ? columns[i] : std::string();
    const bool contact = std::string_view(file) == contacts_file;  // a row is a point of two bodies, named in the first columns
    const NamedColumn parts = contact ? NamedColumn{a[1] + " and " + (a.size() > 2 ? a[2] : ""), column} : parts_of(column);
    Difference found{.file = file, .time = one.time(), .name = parts.name, .column = parts.column, .one = x, .other = y};
    found.what = std::string(thing) + ' ' + in_quotes(parts.name) + ", " + parts.column + ": ";
    if (x.empty() || y.empty())
      found.what +=
          x.empty() ? "absent in the first run, " + y + " in the second" : x + " in the first run, absent in the second";
    else
      found.what += x + " and " + y;
    if (p && q) found.what += ", " + rounded_text(std::fabs(*p - *q), 3) + " apart";
    return found;
  }
  return std::nullopt;
}

}  // namespace

TableEnds compare_tables(const Compared& folders, const char* file, std::vector<Difference>& found) {
  RowReader one(folders.one / file), other(folders.other / file);
  const char* const thing = std::string_view(file) == "bodies.csv"    ? "body"
                            : std::string_view(file) == "springs.csv" ? "spring"
                            : file == contacts_file                   ? "contact"
                                                                      : "joint";
  TableEnds ends;
  if (std::optional<Difference> columns = other_columns(one, other, file, thing)) {
    found.push_back(std::move(*columns));
    rest_of(one), rest_of(other);
    return {0, one.time(), other.time()};
  }
  bool differs = false;
  const auto note = [&](Difference difference) {
    difference.row = ends.rows + 1;
    found.push_back(std::move(difference));
    differs = true;
  };
  const auto longer = [&](bool second, const RowReader& shorter, RowReader& lasting, std::size_t rows, double from) {
    rows += rest_of(lasting);
    if (file == contacts_file) {
      Difference more{.kind = Difference::Kind::rows, .file = file, .time = from};
      more.what =
          "only the " + std::string(second ? "second" : "first") + " run has contacts from t = " + number_text(from) + " s on";
      return note(std::move(more));
    }
    Difference difference{.kind = Difference::Kind::longer, .file = file, .time = from};
    difference.what = "the " + std::string(second ? "first" : "second") + " run ends at t = " + number_text(shorter.time()) +
                      " s; the " + (second ? "second" : "first") + " has " + std::to_string(rows) +
                      " more rows, up to t = " + number_text(lasting.time()) + " s";
    note(std::move(difference));
  };
  while (!differs) {
    const double before = one.time();
    const bool more = one.next(), too = other.next();
    if (!more || !too) {
      if (more) longer(false, other, one, 1, one.time());
      if (too) longer(true, one, other, 1, other.time());
      break;
    }
    if (!near_enough(one.time(), other.time(), folders.tolerance)) {
      // A run that was interrupted ends with a row between two others.
      const bool first_is_behind = one.time() < other.time();
      RowReader &behind = first_is_behind ? one : other, &ahead = first_is_behind ? other : one;
      const double at = behind.time(), next = ahead.time();
      if (ends.rows > 0 && at > before && !behind.next()) {
        longer(first_is_behind, behind, ahead, 1, next);
        break;
      }
      Difference times{.kind = Difference::Kind::rows, .file = file, .time = at};
      times.one = number_text(first_is_behind ? at : next), times.other = number_text(first_is_behind ? next : at);
      times.what = "the rows are at different times, t = " + times.one + " s and " + times.other + " s";
      note(std::move(times));
    } else if (one.line() != other.line()) {
      if (auto cell = other_cell(one, other, file, thing, folders.tolerance)) note(std::move(*cell));
    }
    if (!differs) ++ends.rows;
  }
  rest_of(one), rest_of(other);
  ends.one = one.time(), ends.other = other.time();
  return ends;
}

}  // namespace momentree::io
