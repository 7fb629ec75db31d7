// SPDX-License-Identifier: MIT
#include "demos/runner/csv_file.h"

#include <charconv>
#include <stdexcept>

namespace granular_demo {
namespace {

/// As RFC 4180 has it: within quotes, its own quotes doubled.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char letter : text) result += letter == '"' ? "\"\"" : std::string(1, letter);
  return result + '"';
}

}  // namespace

CsvFile::CsvFile(const std::filesystem::path& file, const std::vector<std::string>& columns)
    : file_(file), columns_(columns.size()), out_(file) {
  for (std::size_t i = 0; i < columns.size(); ++i) out_ << (i > 0 ? "," : "") << columns[i];
  out_ << std::endl;
  if (!out_) throw std::runtime_error(file.string() + ": cannot be written");
}

void CsvFile::row(const std::vector<std::string>& texts, const std::vector<double>& numbers) {
  if (texts.size() + numbers.size() != columns_) {
    throw std::logic_error(file_.string() + ": " + std::to_string(texts.size()) + " texts and " +
                           std::to_string(numbers.size()) + " numbers for " + std::to_string(columns_) +
                           " columns");
  }
  for (std::size_t i = 0; i < texts.size(); ++i) out_ << (i > 0 ? "," : "") << quoted(texts[i]);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, numbers[i]).ptr;
    out_ << (texts.size() + i > 0 ? "," : "");
    out_.write(text, end - text);
  }
  out_ << std::endl;
  if (!out_) throw std::runtime_error(file_.string() + ": cannot be written");
}

}  // namespace granular_demo
