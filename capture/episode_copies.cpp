#include "capture/episode_copies.hpp"

#include "sim/base/content_hash.hpp"

namespace ferrule {
namespace {

std::string hash_of_rows(const EpisodeRows& episode) {
  Sha1 hash;
  for (Eigen::Index n = 0; n < episode.count(); ++n) {
    const auto row = episode.row(n);
    for (const Block& part : {kHandPose, kCommand, kHolder})
      hash.add(row.data() + part.begin, static_cast<std::size_t>(part.width) * sizeof(double));
  }
  return hash.text();
}

}  // namespace

std::string EpisodeCopy::text() const {
  return file + " is left out: it has the rows of " + original + ", a copy";
}

std::optional<EpisodeCopy> EpisodeCopies::seen(const EpisodeRows& episode,
                                               const std::string& file) {
  const auto [first, is_new] = files_.emplace(hash_of_rows(episode), file);
  if (is_new) return std::nullopt;
  return EpisodeCopy{file, first->second};
}

}  // namespace ferrule
