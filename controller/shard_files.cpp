#include "controller/shard_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "sim/base/error.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

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

void expect_version(const Json& block, const std::string& file) {
  const int version = block.value("version", 1);
  if (version != kShardVersion)
    throw FileTrouble(fmt::format(
        "{}: is of version {} of these files, this program has {}: run its shard again, in another "
        "folder",
        file, version, kShardVersion));
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

JobProgress::NotDone JobProgress::not_done() const {
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

ShardFiles::ShardFiles(std::string folder, std::string job)
    : folder_(std::move(folder)), job_(std::move(job)) {}

std::string ShardFiles::file_of(const Shard& shard) const {
  return fmt::format("{}/shard_{:04}_of_{:04}{}", folder_, shard.index, shard.count, kEnding);
}

void ShardFiles::read(const std::string& file) {
  BlockReader& reader = readers_.emplace(file, file).first->second;
  reader.read([&](const Json& block, const BlockReader::Place& place) {
    try {
      take(reader, block, place);
    } catch (const Json::exception&) {
      throw made_up(file, place);
    }
  });
}

void ShardFiles::read_all(const std::string& but) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error)) {
    const fs::path& file = entry.path();
    if (file.extension() == kEnding && !file.filename().string().starts_with('.') && file != but)
      read(file.string());
  }
  if (error) throw FileTrouble(folder_ + ": " + error.message());
}

void ShardFiles::take(const BlockReader& reader, const Json& block,
                      const BlockReader::Place& place) {
  expect_version(block, reader.file());
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
  const Json& trials = block.at("trial");
  progress_.trials += trials.size();
  if (!trials.empty()) campaign->second.blocks.push_back({count_of(trials[0]), &reader, place});
}

JobProgress ShardFiles::progress() const {
  JobProgress now = progress_;
  for (const auto& [file, reader] : readers_)
    if (reader.damaged() > 0) now.damaged.push_back(file);
  return now;
}

void ShardFiles::expect(std::size_t campaign, const std::string& what) const {
  const auto known = campaigns_.find(campaign);
  if (known != campaigns_.end() && known->second.what != what)
    throw FileTrouble(fmt::format(
        "{}: has trials of another scene as campaign {} of this job: it comes from another program "
        "or a machine that calculates differently",
        known->second.file, campaign + 1));
}

void ShardFiles::show_new(std::size_t campaign,
                          const std::function<void(std::size_t, const KeptTrial&)>& show) {
  const auto known = campaigns_.find(campaign);
  if (known == campaigns_.end()) return;
  auto blocks = std::exchange(known->second.blocks, {});
  std::sort(blocks.begin(), blocks.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [_, reader, place] : blocks) {
    const Json block = reader->read_again(place);
    try {
      const Json &trials = block.at("trial"), &columns = block.at("columns");
      for (std::size_t row = 0; row < trials.size(); ++row)
        show(count_of(trials[row]), KeptTrial(columns, row));
    } catch (const Json::exception&) {
      throw made_up(reader->file(), place);
    }
  }
}

}  // namespace ferrule
