// What is said to a page about a sitting (view/session.hpp, view/playground/), each a JSON object.
#pragma once

#include "capture/episode.hpp"
#include "capture/score.hpp"
#include "insertion/loop.hpp"

namespace ferrule {

// Of a page's first message: what it will hear of. "device" holds the fibre, "folder" has the episodes.
Json hello_json(const Scene& scene, const std::string& device, const std::string& folder);

// An insertion that ended, of a start that is drawn by `trial`.
Json ended_json(const InsertionEnd& end, std::uint64_t trial);
// With what a try came to.
void add_score(Json& ended, const Measures& measures, const Score& score);

// An episode on the list. `same_scene`: as the one that is tried; its score is NaN where there is none.
Json listed_json(const std::string& file, const EpisodeInfo& info, const Scene& scene,
                 const Measures& measures, bool same_scene, double score);

}  // namespace ferrule
