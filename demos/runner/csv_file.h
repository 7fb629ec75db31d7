// SPDX-License-Identifier: MIT
// A CSV file of numbers: one line of column names, then rows, which may begin with texts. Each row is on disk
// when `row` returns, so that an interrupted run leaves whole lines. Numbers are written so that they read
// back to the same bits.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace granular_demo {

class CsvFile {
 public:
  /// Throws std::runtime_error if the file cannot be written.
  CsvFile(const std::filesystem::path& file, const std::vector<std::string>& columns);
  /// As many numbers as there are columns.
  void row(const std::vector<double>& numbers) { row({}, numbers); }
  /// Texts for the first columns, numbers for the rest. A text may hold anything: it is quoted.
  void row(const std::vector<std::string>& texts, const std::vector<double>& numbers);

 private:
  std::filesystem::path file_;
  std::size_t columns_;
  std::ofstream out_;
};

}  // namespace granular_demo
