#include "controller/trial_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <thread>
#include <utility>

#include "sim/base/error.hpp"

namespace ferrule {
namespace {

using std::chrono::steady_clock;

constexpr auto kBetweenBlocks = std::chrono::seconds(1);
constexpr auto kBetweenLooks = std::chrono::milliseconds(500);

}  // namespace

TrialStore::TrialStore(std::string folder, std::string job, std::optional<Shard> shard, bool waits)
    : job_(std::move(job)), shard_(shard), waits_(waits) {
  files_.emplace(std::move(folder), job_);
  if (shard_) {
    const std::string own = files_->file_of(*shard_);
    writer_ = std::make_unique<BlockWriter>(own);
    files_->read(own);
  } else {
    files_->read_all();
  }
}

void TrialStore::begin(std::vector<Campaign> campaigns, bool all) {
  all_ = all || tells();
  for (Campaign& campaign : campaigns) {
    const std::size_t first = all_ ? 0 : shard_->index - 1, stride = all_ ? 1 : shard_->count;
    const std::size_t count =
        first < campaign.trials ? (campaign.trials - first + stride - 1) / stride : 0;
    if (files_) files_->expect(begun_, campaign.what);
    running_.push_back({std::move(campaign), begun_++, first, stride, std::vector<bool>(count)});
    if (writer_) unwritten_[running_.size() - 1];  // a block without trials says that it has begun
  }
  if (writer_) flush();
  if (files_) look_around();
}

std::optional<TrialStore::Trial> TrialStore::next() {
  if (look_.exchange(false)) look_around();
  const std::lock_guard lock(mutex_);
  for (; front_ < running_.size(); ++front_)
    for (Running& r = running_[front_]; !r.ended && r.next < r.kept.size();) {
      const std::size_t i = r.next++, trial = r.first + i * r.stride;
      if (!r.kept[i] && is_mine(trial)) return Trial{front_, trial};
    }
  return std::nullopt;
}

void TrialStore::put(const Trial& trial, const std::function<Json()>& result) {
  if (!files_) return;
  Json kept = result();
  const std::lock_guard lock(mutex_);
  Running& r = running_[trial.campaign];
  r.kept[(trial.trial - r.first) / r.stride] = true;
  auto& [trials, columns] = unwritten_[trial.campaign];
  trials.push_back(trial.trial);
  for (auto& [key, value] : kept.items()) columns[key].push_back(std::move(value));
  if (steady_clock::now() - written_ < kBetweenBlocks) return;
  flush();
  look_ = all_;
}

void TrialStore::end(std::size_t campaign) {
  const std::lock_guard lock(mutex_);
  running_[campaign].ended = true;
}

void TrialStore::done(const std::function<bool()>& stop) {
  if (writer_) {
    const std::lock_guard lock(mutex_);
    flush();
  }
  for (const Running& running : running_) {
    if (!shard_)
      if (const auto lacking = missing(running); !lacking.empty()) refuse(running, lacking);
    while (shard_ && waits_ && !missing(running).empty() && !(stop && stop())) {
      std::this_thread::sleep_for(kBetweenLooks);
      look_around();
    }
  }
  running_.clear();
  front_ = 0;
}

void TrialStore::finish() {
  writer_->append(block({{"done", true}}));
}

bool TrialStore::is_mine(std::size_t trial) const noexcept {
  return shard_ && trial % shard_->count == shard_->index - 1;
}

// What is in its own file was read at the start, and in a merge all was.
void TrialStore::look_around() {
  const std::lock_guard lock(reading_);
  if (shard_ && all_) files_->read_all(files_->file_of(*shard_));
  for (Running& running : running_)
    files_->show_new(running.number,
                     [&](std::size_t trial, const KeptTrial& kept) { take(running, trial, kept); });
}

void TrialStore::take(Running& running, std::size_t trial, const KeptTrial& kept) {
  if (trial >= running.trials || (!all_ && !is_mine(trial))) return;
  {
    const std::lock_guard lock(mutex_);
    if (running.ended) return;
    auto known = running.kept[(trial - running.first) / running.stride];
    twice_ += known;
    known = true;
  }
  if (!running.take(trial, kept))
    throw FileTrouble(fmt::format(
        "{}: trial {} of campaign {} is there twice and went differently: one of them comes from "
        "another program or a machine that calculates differently",
        files_->folder(), trial, running.number + 1));
}

std::vector<std::size_t> TrialStore::missing(const Running& running) {
  const std::lock_guard lock(mutex_);
  std::vector<std::size_t> trials;
  for (std::size_t i = 0; !running.ended && i < running.kept.size(); ++i)
    if (!running.kept[i]) trials.push_back(running.first + i * running.stride);
  return trials;
}

void TrialStore::refuse(const Running& running, const std::vector<std::size_t>& missing) const {
  const std::size_t count = std::max<std::size_t>(1, files_->progress().count());
  std::set<Shard> lacking;
  for (const std::size_t trial : missing) lacking.insert({trial % count + 1, count});
  throw FileTrouble(
      fmt::format("{}: of campaign {}, {} trials are missing, {} the first: run {} again",
                  files_->folder(), running.number + 1, missing.size(), missing.front(),
                  to_text(std::vector<Shard>(lacking.begin(), lacking.end()), lacking.size())));
}

Json TrialStore::block(Json content) const {
  content["version"] = kShardVersion;
  content["job"] = job_;
  content["shard"] = {shard_->index, shard_->count};
  return content;
}

void TrialStore::flush() {
  for (auto& [campaign, unwritten] : unwritten_)
    writer_->append(block({{"campaign", running_[campaign].number},
                           {"what", running_[campaign].what},
                           {"of", running_[campaign].trials},
                           {"trial", std::move(unwritten.trials)},
                           {"columns", std::move(unwritten.columns)}}));
  unwritten_.clear();
  written_ = steady_clock::now();
}

}  // namespace ferrule
