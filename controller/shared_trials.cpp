#include "controller/shared_trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "sim/base/error.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

constexpr auto kBetweenBlocks = std::chrono::seconds(1);
constexpr const char* kEnding = ".trials";
constexpr std::size_t kMostNamed = 8;  // shards in a message

// A number that counts. Throws Json::exception where it is none.
std::size_t count_of(const Json& number) {
  if (!number.is_number_integer() || number < 0)
    throw Json::type_error::create(302, "no count", &number);
  return number;
}

// A block, or a result in it, that no shard has written.
FileTrouble made_up(const std::string& file, const BlockReader::Place& place) {
  return FileTrouble(
      fmt::format("{}: has no trials of this program in the block at byte {}", file, place.at));
}

}  // namespace

std::string to_text(const Shard& shard) {
  return fmt::format("{}/{}", shard.index, shard.count);
}

std::string to_text(const std::vector<Shard>& first, std::size_t count) {
  const std::size_t shown = std::min(kMostNamed, first.size());
  std::string text = count == 1 ? "shard" : "shards";
  for (std::size_t i = 0; i < shown; ++i) text += (i > 0 ? ", " : " ") + to_text(first[i]);
  if (count > shown) text += fmt::format(" and {} more", count - shown);
  return text;
}

SharedTrials::SharedTrials(std::string folder, std::string job, std::optional<Shard> shard,
                           bool waits)
    : folder_(std::move(folder)), job_(std::move(job)), shard_(shard), waits_(waits) {
  if (shard_) {
    own_ = fmt::format("{}/shard_{:04}_of_{:04}{}", folder_, shard_->index, shard_->count, kEnding);
    writer_ = std::make_unique<BlockWriter>(own_);
    read(own_);
  } else {
    look_around();
  }
}

void SharedTrials::read(const std::string& file) {
  const auto added = readers_.emplace(file, file);
  if (file == own_ && !added.second) return;  // what is new there is of this process
  BlockReader& reader = added.first->second;
  reader.read([&](const Json& block, const BlockReader::Place& place) {
    try {
      take(reader, block, place);
    } catch (const Json::exception&) {
      throw made_up(file, place);
    }
  });
}

void SharedTrials::look_around() {
  const std::lock_guard lock(reading_);
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error))
    if (entry.path().extension() == kEnding && !entry.path().filename().string().starts_with('.'))
      read(entry.path().string());
  if (error) throw FileTrouble(folder_ + ": " + error.message());
}

void SharedTrials::take(const BlockReader& reader, const Json& block,
                        const BlockReader::Place& place) {
  if (block.value("job", std::string()) != job_) {
    ++progress_.others;
    return;
  }
  const Shard shard{count_of(block.at("shard").at(0)), count_of(block.at("shard").at(1))};
  if (shard.index < 1 || shard.index > shard.count) throw made_up(reader.file(), place);
  progress_.counts.insert(shard.count);
  if (block.contains("done")) progress_.done.insert(shard);
  if (!block.contains("campaign")) return;
  const std::size_t number = count_of(block.at("campaign"));
  const auto [campaign, is_new] =
      campaigns_.emplace(number, Campaign{block.at("what"), reader.file()});
  if (is_new) {
    ++progress_.campaigns;
    progress_.begun += count_of(block.at("of"));
  }
  if (campaign->second.what != block.at("what").get<std::string>())
    throw FileTrouble(fmt::format(
        "{} and {}: have trials of different scenes as campaign {} of the same job: one of them "
        "comes from another program or a machine that calculates differently",
        campaign->second.file, reader.file(), number + 1));
  const Json& trials = block.at("trials");
  progress_.trials += trials.size();
  if (!trials.empty())
    campaign->second.blocks.push_back({count_of(trials[0].at(0)), &reader, place});
}

std::size_t SharedTrials::begin(const std::string& what, std::size_t trials) {
  const std::size_t number = begun_.size();
  begun_.push_back({what, trials});
  const auto known = campaigns_.find(number);
  if (known != campaigns_.end() && known->second.what != what)
    throw FileTrouble(fmt::format(
        "{}: has trials of another scene as campaign {} of this job: it comes from another program "
        "or a machine that calculates differently",
        known->second.file, number + 1));
  if (shard_) write(number, Json::array());
  return number;
}

std::size_t SharedTrials::found(std::size_t first, const std::function<void(const Found&)>& show) {
  const std::lock_guard lock(reading_);
  std::size_t count = 0;
  for (auto& [number, campaign] : campaigns_) {
    if (number >= begun_.size()) break;
    auto blocks = std::exchange(campaign.blocks, {});
    if (number < first) continue;
    std::sort(blocks.begin(), blocks.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [_, reader, place] : blocks) {
      Json block = reader->read_again(place);
      try {
        for (Json& trial : block.at("trials")) {
          show({number, count_of(trial.at(0)), std::move(trial.at(1))});
          ++count;
        }
      } catch (const Json::exception&) {
        throw made_up(reader->file(), place);
      }
    }
  }
  return count;
}

void SharedTrials::keep(std::size_t campaign, std::size_t trial, Json result) {
  const std::lock_guard lock(mutex_);
  kept_[campaign].push_back({trial, std::move(result)});
  if (steady_clock::now() - written_ < kBetweenBlocks) return;
  flush();
  wrote_ = true;
}

void SharedTrials::write(std::size_t campaign, Json trials) {
  writer_->append({{"job", job_},
                   {"shard", {shard_->index, shard_->count}},
                   {"campaign", campaign},
                   {"what", begun_[campaign].what},
                   {"of", begun_[campaign].trials},
                   {"trials", std::move(trials)}});
}

void SharedTrials::flush() {
  for (auto& [number, trials] : kept_) write(number, std::move(trials));
  kept_.clear();
  written_ = steady_clock::now();
}

void SharedTrials::again(const Found& found, const Json& before) {
  ++progress_.twice;
  if (Json::to_cbor(before) == Json::to_cbor(found.result)) return;  // NaN is like NaN
  throw FileTrouble(fmt::format(
      "{}: trial {} of campaign {} is there twice and went differently: one of them comes from "
      "another program or a machine that calculates differently",
      folder_, found.trial, found.campaign + 1));
}

void SharedTrials::refuse_missing(std::size_t campaign,
                                  const std::vector<std::size_t>& trials) const {
  const std::size_t count = std::max<std::size_t>(1, progress_.count());
  std::set<Shard> lacking;
  for (const std::size_t trial : trials) lacking.insert({trial % count + 1, count});
  throw FileTrouble(
      fmt::format("{}: of campaign {}, {} trials are missing, {} the first: run {} again", folder_,
                  campaign + 1, trials.size(), trials.front(),
                  to_text(std::vector<Shard>(lacking.begin(), lacking.end()), lacking.size())));
}

void SharedTrials::finish() {
  const std::lock_guard lock(mutex_);
  flush();
  writer_->append({{"job", job_}, {"shard", {shard_->index, shard_->count}}, {"done", true}});
}

SharedTrials::Progress::NotDone SharedTrials::Progress::not_done() const {
  NotDone lacking;
  for (const std::size_t of : counts) {  // the last is the most
    const auto finished = static_cast<std::size_t>(std::count_if(
        done.begin(), done.end(), [of](const Shard& shard) { return shard.count == of; }));
    lacking = {of - finished, {}};
    if (lacking.count == 0) return {};
    for (std::size_t i = 1; i <= of && lacking.first.size() < kMostNamed; ++i)
      if (!done.contains({i, of})) lacking.first.push_back({i, of});
  }
  return lacking;
}

SharedTrials::Progress SharedTrials::progress() {
  look_around();
  Progress now = progress_;
  for (const auto& [file, reader] : readers_)
    if (reader.damaged() > 0) now.damaged.push_back(file);
  return now;
}

}  // namespace ferrule
