// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/files/result.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"
#include "sarblock/tables/output.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tables/table.h"
#include <nlohmann/json.hpp>

namespace sarblock {

/// part.json: what a folder holds a part of. The draws are a function of it alone.
struct PartOrigin {
  TaskPart part;
  std::string version;   ///< of the program
  std::string solution;  ///< MonteCarloDraws::solution, 16 hexadecimal digits
  std::vector<InputFile> inputs;
  nlohmann::ordered_json configuration;
  std::vector<InputFile> tables;  ///< draws.csv and sums.csv (or as .csv.gz)
};

/// Writes the draws of options.montecarlo_part as a folder (docs/formats.md): part.json, draws.csv
/// and sums.csv, all or none. Returns part.json.
std::string WriteMonteCarloPart(const std::filesystem::path& folder,
                                const Block& block,
                                const AdjustOptions& options,
                                const MonteCarloDraws& draws,
                                const std::vector<InputFile>& inputs,
                                Compression compression);

/// Reads part.json; InputError where it is none.
[[nodiscard]] PartOrigin ReadPartOrigin(const TableSource& source);

/// Adds the tables of a part: the runs of `part` of options.montecarlo_runs behind those
/// in `draws`, its sums to those of the points there. InputError, and `draws` half changed, where
/// the tables have other runs or points, or sums that such runs cannot have.
void AddPartTables(const TableSource& source,
                   const TaskPart& part,
                   std::size_t runs,
                   const IdTable& ids,
                   MonteCarloDraws* draws);

/// The parts of one adjustment. A refusal names the folder.
class MonteCarloParts {
 public:
  /// Opens the folders; refuses what is no part, was damaged, is missing or there twice, or belongs
  /// to another adjustment than that of `options` and `inputs`: before anything is computed.
  MonteCarloParts(const std::vector<std::string>& folders,
                  const AdjustOptions& options,
                  const std::vector<InputFile>& inputs);

  /// Makes the report of an adjustment that drew no run itself (TaskPart::None()) from the parts,
  /// one at a time; refuses draws about another solution.
  void Join(const Block& block, const AdjustOptions& options, AdjustResult* result) const;

 private:
  PartFolders folders_;
  std::vector<PartOrigin> origins_;
};

}  // namespace sarblock
