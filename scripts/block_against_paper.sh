#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What an adjustment gains over the 1979 formulas: the tables of docs/validation.md, "Block against
# paper", in Markdown. For the aircraft and the VOIR scene, without control, with four corners and
# with a dense net: `simulate`, `predict` at the levels intersection and block (sigmas at the true
# positions) and `adjust` (errors of check points).
#
# Usage: scripts/block_against_paper.sh SARBLOCK FOLDER     the program, and where to put the blocks
set -eu
sarblock=$1
folder=$2
root=$(cd -- "$(dirname -- "$0")/.." && pwd)
mkdir -p "$folder"

# median FILE COLUMN...: of each column over the rows whose column role is "tie" (if there is one)
median() {
  file=$1
  shift
  for column in "$@"; do
    awk -F, -v name="$column" '
      NR == 1 { for (i = 1; i <= NF; ++i) { if ($i == name) c = i; if ($i == "role") r = i }; next }
      (!r || $r == "tie") && $c != "" { print $c < 0 ? -$c : $c }' "$file" | sort -g |
      awk '{ v[NR] = $1 } END { printf "%.9g ", NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2 }'
  done
}

rms() { # FILE COLUMN
  awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; next }
    $c != "" { s += $c * $c; ++n } END { printf "%.9g ", sqrt(s / n) }' "$1"
}

# spread FILE: largest relative difference between paper and block, across and up
spread() {
  awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; next }
    $(at["role"]) == "tie" {
      y = sqrt($(at["sigma_leberl_across_m"]) ^ 2 + $(at["sigma_leberl_path_across_m"]) ^ 2)
      z = sqrt($(at["sigma_leberl_up_m"]) ^ 2 + $(at["sigma_leberl_path_up_m"]) ^ 2)
      a = y / $(at["sigma_n_m"]) - 1; b = z / $(at["sigma_u_m"]) - 1
      if (a < 0) a = -a
      if (b < 0) b = -b
      if (a > most) most = a
      if (b > most) most = b
    } END { printf "%.1e\n", most }' "$1"
}

# pair_lines POINTS INTERSECTION BLOCK B H sigma_y sigma_z: for each pair the size of the difference,
# its noise, the path part by Eq. 18, 19, 22 and 23 (derived signs), and rigorously by the block
pair_lines() {
  awk -F, -v base="$4" -v height="$5" -v sy="$6" -v sz="$7" '
    FNR == 1 { ++file; for (i = 1; i <= NF; ++i) at[file, $i] = i; next }
    file == 1 { y[$1] = $(at[1, "y_m"]); h[$1] = height - $(at[1, "z_m"]); next }
    file == 2 { nn[$1, $2] = $(at[2, "cov_nn_m2"]); uu[$1, $2] = $(at[2, "cov_uu_m2"]); next }
    {
      dy = $(at[3, "dn_m"]); dz = $(at[3, "du_m"]); db = sqrt(2) * sy; dh = sqrt(2) * sz
      eq18 = dy / base * db
      eq19 = (dy * (base - 2 * y[$1]) / (base * h[$1]) + dz * y[$1] * (base - y[$1]) / (base * h[$1] ^ 2)) * db
      eq22 = dz / base * dh
      eq23 = dy / base * dh
      ry = $(at[3, "cov_nn_m2"]) - nn[$1, $2]; rz = $(at[3, "cov_uu_m2"]) - uu[$1, $2]
      print (dy < 0 ? -dy : dy) "," sqrt(nn[$1, $2]) "," sqrt(uu[$1, $2]) "," sqrt(eq18 ^ 2 + eq22 ^ 2) "," \
        sqrt(eq19 ^ 2 + eq23 ^ 2) "," sqrt(ry > 0 ? ry : 0) "," sqrt(rz > 0 ? rz : 0) "," \
        sqrt($(at[3, "cov_nn_m2"])) "," sqrt($(at[3, "cov_uu_m2"]))
    }' "$1" "$2" "$3"
}

points=$folder/points.md
pairs=$folder/pairs.md
: > "$points"
: > "$pairs"
for scene in leberl-aircraft leberl-voir; do
  case $scene in
    leberl-aircraft) geometry="8000 10000 100 10" ;;
    *) geometry="40000 375000 1000 100" ;;
  esac
  for control in "none 0" "corners 4" "grid 100"; do
    layout=${control% *}
    count=${control#* }
    at=$folder/$scene-$layout
    rm -rf "$at"*
    "$sarblock" simulate "$root/datasets/scenes/$scene.toml" -o "$at" --quiet \
      --set "control.layout=$layout" --set "control.count=$count" > /dev/null
    for level in intersection block; do
      "$sarblock" predict "$at" -o "$at.$level" --quiet --set covariance=$level \
        --set pairs=neighbours > /dev/null
    done
    "$sarblock" adjust "$at" -o "$at.adjusted" --quiet > /dev/null
    # shellcheck disable=SC2046,SC2183
    printf '| %s | %s | %.3g, %.3g | %.3g, %.3g | %.4g, %.4g | %.4g, %.4g | %s | %.3g, %.3g |\n' \
      "$scene" "$count" \
      $(median "$at.block/points.csv" sigma_leberl_across_m sigma_leberl_up_m) \
      $(median "$at.intersection/points.csv" sigma_n_m sigma_u_m) \
      $(median "$at.block/points.csv" sigma_leberl_path_across_m sigma_leberl_path_up_m) \
      $(median "$at.block/points.csv" sigma_n_m sigma_u_m) \
      "$(spread "$at.block/points.csv")" \
      $(rms "$at.adjusted/points.csv" error_n_m) $(rms "$at.adjusted/points.csv" error_u_m) \
      >> "$points"
    # shellcheck disable=SC2086
    {
      echo "dy,noise_y,noise_z,formula_y,formula_z,path_y,path_z,block_y,block_z"
      pair_lines "$at.block/points.csv" "$at.intersection/pairs.csv" "$at.block/pairs.csv" $geometry
    } > "$at.pairs.csv"
    # shellcheck disable=SC2046,SC2183
    printf '| %s | %s | %.3g | %.4g, %.4g | %.3g, %.3g | %.3g, %.3g | %.3g, %.3g | %.3g, %.3g |\n' \
      "$scene" "$count" $(median "$at.pairs.csv" dy) \
      $(median "$at.block/points.csv" sigma_n_m sigma_u_m) \
      $(median "$at.pairs.csv" noise_y noise_z formula_y formula_z path_y path_z block_y block_z) \
      >> "$pairs"
  done
done

cat << 'END'
| scene | control | Eq. 25: y, z | intersection: y, z | Eq. 14, 15 of the priors: y, z | block: y, z | paper / block - 1, largest | check points, rms of y, z |
| --- | --- | --- | --- | --- | --- | --- | --- |
END
cat "$points"
cat << 'END'

| scene | control | median of abs(Dy) | point, block: y, z | range noise: Dy, Dz | Eq. 18-23: Dy, Dz | path part of the block: Dy, Dz | block, all: Dy, Dz |
| --- | --- | --- | --- | --- | --- | --- | --- |
END
cat "$pairs"
