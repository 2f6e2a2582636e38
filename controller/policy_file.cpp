#include "controller/policy_file.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "controller/safetensors.hpp"
#include "sim/base/content_hash.hpp"
#include "sim/base/control_period.hpp"
#include "sim/base/json_file.hpp"
#include "sim/base/written_file.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kWeights = ".safetensors";
constexpr std::size_t kHashDigits = 12;  // in the name of a file of weights
constexpr std::int64_t kMostMembers = 100, kMostLayers = 8, kMostUnits = 1024;
constexpr std::int64_t kMostSamples = 100, kMostSpacing = 10000;
constexpr std::uintmax_t kMostBytes = 1 << 28;  // of the weights' file

std::string weight_name(std::size_t member, std::size_t layer, const char* what) {
  return fmt::format("members.{}.layers.{}.{}", member, layer, what);
}

std::string memory_name(std::size_t member, const char* what) {
  return fmt::format("members.{}.memory.{}", member, what);
}

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Tensor to_tensor(const RowMajor& m) {
  return {{static_cast<std::size_t>(m.rows()), static_cast<std::size_t>(m.cols())},
          std::vector<float>(m.data(), m.data() + m.size())};
}

Tensor vector_to_tensor(const Eigen::VectorXf& v) {
  return {{static_cast<std::size_t>(v.size())}, std::vector<float>(v.data(), v.data() + v.size())};
}

Tensors to_tensors(const Policy& policy) {
  Tensors tensors;
  for (std::size_t m = 0; m < policy.members.size(); ++m)
    for (std::size_t i = 0; i < policy.members[m].size(); ++i) {
      tensors[weight_name(m, i, "weight")] = to_tensor(policy.members[m][i].weight);
      tensors[weight_name(m, i, "bias")] = vector_to_tensor(policy.members[m][i].bias);
    }
  for (std::size_t m = 0; m < policy.memories.size(); ++m) {
    const Gru& gru = policy.memories[m];
    tensors[memory_name(m, "input_weight")] = to_tensor(gru.input_weight);
    tensors[memory_name(m, "memory_weight")] = to_tensor(gru.memory_weight);
    tensors[memory_name(m, "input_bias")] = vector_to_tensor(gru.input_bias);
    tensors[memory_name(m, "memory_bias")] = vector_to_tensor(gru.memory_bias);
  }
  return tensors;
}

// Takes an array of `shape` out of `tensors`.
std::vector<float> take(Tensors& tensors, const std::string& name,
                        const std::vector<std::size_t>& shape, const std::string& file) {
  const auto found = tensors.find(name);
  if (found == tensors.end()) throw BadInput(file + ": " + name + " is missing");
  if (found->second.shape != shape)
    throw BadInput(fmt::format("{}: {}.shape: must be {} by the controller's layers", file, name,
                               Json(shape).dump()));
  std::vector<float> values = std::move(found->second.values);
  tensors.erase(found);
  return values;
}

Eigen::MatrixXf take_matrix(Tensors& tensors, const std::string& name, std::size_t rows,
                            std::size_t columns, const std::string& file) {
  const std::vector<float> values = take(tensors, name, {rows, columns}, file);
  return Eigen::Map<const RowMajor>(values.data(), static_cast<Eigen::Index>(rows),
                                    static_cast<Eigen::Index>(columns));
}

Eigen::VectorXf take_vector(Tensors& tensors, const std::string& name, std::size_t size,
                            const std::string& file) {
  const std::vector<float> values = take(tensors, name, {size}, file);
  return Eigen::Map<const Eigen::VectorXf>(values.data(), static_cast<Eigen::Index>(size));
}

// Of the policy, whose memories have no weights yet, `widths` from what is below the first layer.
void from_tensors(Tensors tensors, const std::vector<std::size_t>& widths, const std::string& file,
                  Policy& policy) {
  const auto inputs = static_cast<std::size_t>(policy.inputs());
  for (std::size_t m = 0; m < policy.memories.size(); ++m) {
    const std::size_t units = widths.front();
    policy.memories[m] = {
        take_matrix(tensors, memory_name(m, "input_weight"), 3 * units, inputs, file),
        take_matrix(tensors, memory_name(m, "memory_weight"), 3 * units, units, file),
        take_vector(tensors, memory_name(m, "input_bias"), 3 * units, file),
        take_vector(tensors, memory_name(m, "memory_bias"), 3 * units, file)};
  }
  for (std::size_t m = 0; m < policy.members.size(); ++m)
    for (std::size_t i = 0; i + 1 < widths.size(); ++i)
      policy.members[m].push_back(
          {take_matrix(tensors, weight_name(m, i, "weight"), widths[i + 1], widths[i], file),
           take_vector(tensors, weight_name(m, i, "bias"), widths[i + 1], file)});
  if (!tensors.empty())
    throw BadInput(file + ": " + tensors.begin()->first + ": no such array in the controller");
}

template <class Channel>
Json scaled_channel(const Channel& channel, double mean, double scale) {
  return {{"name", channel.name}, {"unit", channel.unit}, {"mean", mean}, {"scale", scale}};
}

// Calls `read(fields of entry, index)` for each object of the list at `key`.
template <class Read>
void for_each(JsonFields& fields, const std::string& key, std::size_t least, std::size_t most,
              Read read) {
  const Json& list = fields.raw(key);
  if (!list.is_array() || list.size() < least || list.size() > most)
    fields.refuse(key, least == most ? fmt::format("must be a list of {} objects", least)
                                     : std::string("must be a list of objects"));
  for (std::size_t i = 0; i < list.size(); ++i) {
    JsonFields entry = fields.object(key, i);
    read(entry, i);
    entry.finish();
  }
}

std::size_t count(JsonFields& fields, const std::string& key) {
  return static_cast<std::size_t>(fields.integer(key, 0, INT64_MAX));
}

// How many members, with a memory of how many units (0: none), what a policy takes in and answers,
// and when.
std::size_t read_signature(JsonFields& fields, Policy& policy) {
  policy.members.resize(static_cast<std::size_t>(fields.integer("ensemble", 1, kMostMembers)));
  std::size_t units = 0;
  if (fields.has("memory")) {
    units = static_cast<std::size_t>(fields.integer("memory", 1, kMostUnits));
    policy.memories.resize(policy.members.size());
  }
  policy.period =
      fields.number("period_s", rule::between(kControlPeriod, kControlPeriod, "must be 0.001"));
  JsonFields history = fields.object("history");
  policy.samples = static_cast<int>(history.integer("samples", 1, units > 0 ? 1 : kMostSamples));
  policy.spacing = static_cast<int>(history.integer("spacing_periods", 1, kMostSpacing));
  history.finish();
  const auto channels = policy.channels();
  for_each(fields, "inputs", channels.size(), channels.size(),
           [&](JsonFields& entry, std::size_t i) {
             entry.choice("name", {channels[i].name});
             entry.choice("unit", {channels[i].unit});
             policy.mean[i] = entry.number("mean", rule::any());
             policy.scale[i] = entry.number("scale", rule::positive());
           });
  const Json& outputs = fields.raw("outputs");
  const auto answers = outputs.is_array() && outputs.size() == kTwist ? kTwist : kVelocity;
  policy.velocity_mean = policy.velocity_scale = PolicyTwist::Zero(answers);
  for_each(fields, "outputs", answers, answers, [&](JsonFields& entry, std::size_t i) {
    entry.choice("name", {kPolicyAnswer[i].name});
    entry.choice("unit", {kPolicyAnswer[i].unit});
    policy.velocity_mean[static_cast<Eigen::Index>(i)] = entry.number("mean", rule::any());
    policy.velocity_scale[static_cast<Eigen::Index>(i)] =
        entry.number("scale", rule::not_negative());
  });
  JsonFields limits = fields.object("limits");
  policy.speed_limit = limits.number("speed_m_s", rule::positive());
  for (const auto& [key, value] :
       {std::pair("lowest_log_sd", kLowestLogSd), std::pair("highest_log_sd", kHighestLogSd)})
    limits.number(key, rule::between(value, value, fmt::format("must be {}", value)));
  limits.finish();
  return units;
}

void read_metrics(JsonFields metrics, PolicyFile& p) {
  for_each(metrics, "members", 0, kMostMembers, [&](JsonFields& entry, std::size_t) {
    p.members.push_back({static_cast<int>(entry.integer("epochs", 0, INT32_MAX)),
                         static_cast<int>(entry.integer("best_epoch", 0, INT32_MAX)),
                         entry.number("training_loss", rule::any()),
                         entry.number("held_out_loss", rule::any())});
    if (!entry.present("rollouts")) return;
    p.members.back().rollouts = count(entry, "rollouts");
    p.members.back().inserted = count(entry, "inserted");
  });
  p.residual = metrics.number("residual_m_s", rule::not_negative());
  p.held_out_residual = metrics.number_or_nan("held_out_residual_m_s", rule::not_negative());
  for_each(metrics, "dagger", 0, SIZE_MAX, [&](JsonFields& entry, std::size_t) {
    p.dagger.push_back({count(entry, "trials"), count(entry, "inserted"), count(entry, "rows"),
                        entry.number("held_out_loss", rule::any())});
  });
  metrics.finish();
}

// Inputs or units of the memory, units of each hidden layer, outputs.
std::vector<std::size_t> read_widths(JsonFields& fields, const Policy& policy, std::size_t memory) {
  std::vector<std::size_t> widths = {memory > 0 ? memory
                                                : static_cast<std::size_t>(policy.inputs())};
  const std::string expected =
      fmt::format("must be a list of 1 to {} whole numbers from 1 to {}", kMostLayers, kMostUnits);
  const Json& hidden = fields.raw("hidden");
  if (!hidden.is_array() || hidden.empty() || hidden.size() > kMostLayers)
    fields.refuse("hidden", expected);
  for (const Json& each : hidden) {
    if (!each.is_number_unsigned() || each.get<std::uint64_t>() < 1 ||
        each.get<std::uint64_t>() > kMostUnits)
      fields.refuse("hidden", expected);
    widths.push_back(each);
  }
  widths.push_back(std::size_t{2} * static_cast<std::size_t>(policy.answers()));
  return widths;
}

// Removes weights that were made for `file` and that no controller file beside it names any more,
// and those that killed runs left half-written.
void remove_old_weights(const std::string& file) {
  std::error_code error;
  const std::string stem = fs::path(file).stem().string() + ".";
  const auto are_weights = [&](const std::string& name) {
    const bool sized = name.size() == stem.size() + kHashDigits + kWeights.size();
    return sized && name.starts_with(stem) && name.ends_with(kWeights) &&
           name.find_first_not_of("0123456789abcdef", stem.size()) == stem.size() + kHashDigits;
  };
  const fs::path parent = fs::path(file).parent_path(), folder = parent.empty() ? "." : parent;
  remove_half_written(folder.string(), are_weights);
  std::vector<fs::path> old;
  std::string controllers;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file(error)) continue;
    if (name.ends_with(".json") || name == fs::path(file).filename())
      controllers += read_text(entry.path().string());
    if (are_weights(name)) old.push_back(entry.path());
  }
  for (const fs::path& weights : old)
    if (controllers.find(weights.filename().string()) == controllers.npos)
      fs::remove(weights, error);
}

std::string read_weights(const std::string& file) {
  std::error_code error;
  if (fs::is_regular_file(file, error) && fs::file_size(file, error) > kMostBytes)
    throw BadInput(file + ": larger than any policy: more than 256 MiB");
  return read_text(file);
}

Json to_json(const MemberTraining& m) {
  Json entry = {{"epochs", m.epochs},
                {"best_epoch", m.best_epoch},
                {"training_loss", m.training_loss},
                {"held_out_loss", m.held_out_loss}};
  if (m.rollouts > 0) entry.update({{"rollouts", m.rollouts}, {"inserted", m.inserted}});
  return entry;
}

}  // namespace

std::string weights_file(const std::string& file, const std::string& hash) {
  if (file.ends_with(kWeights))
    throw BadInput(file + ": a controller file must not end in .safetensors, its weights do");
  return fs::path(file)
      .replace_extension("." + hash.substr(0, kHashDigits) + std::string(kWeights))
      .string();
}

std::size_t PolicyFile::parameters() const {
  Eigen::Index count = 0;
  for (const Network& network : policy.members)
    for (const Layer& layer : network) count += layer.weight.size() + layer.bias.size();
  for (const Gru& gru : policy.memories)
    count += gru.input_weight.size() + gru.memory_weight.size() + gru.input_bias.size() +
             gru.memory_bias.size();
  return static_cast<std::size_t>(count);
}

void write_controller(const std::string& file, const PolicyFile& p) {
  const Policy& policy = p.policy;
  const std::string bytes =
      safetensors_bytes(to_tensors(policy), {{"format", kControllerFormat}, {"method", "torch"}});
  const std::string hash = sha1(bytes);
  const fs::path weights = weights_file(file, hash);

  Json hidden = Json::array(), inputs = Json::array(), outputs = Json::array();
  Json training = Json::array(), rounds = Json::array();
  for (std::size_t i = 0; i + 1 < policy.members.front().size(); ++i)
    hidden.push_back(policy.members.front()[i].bias.size());
  for (std::size_t i = 0; i < policy.channels().size(); ++i)
    inputs.push_back(scaled_channel(policy.channels()[i], policy.mean[i], policy.scale[i]));
  for (int i = 0; i < policy.answers(); ++i)
    outputs.push_back(scaled_channel(kPolicyAnswer[static_cast<std::size_t>(i)],
                                     policy.velocity_mean[i], policy.velocity_scale[i]));
  for (const MemberTraining& m : p.members) training.push_back(to_json(m));
  for (const DaggerRound& r : p.dagger)
    rounds.push_back({{"trials", r.trials},
                      {"inserted", r.inserted},
                      {"rows", r.rows},
                      {"held_out_loss", r.held_out_loss}});
  Json json = {{"format", kControllerFormat},
               {"format_version", 1},
               {"method", "torch"},
               {"world", "hand"},
               {"weights", weights.filename().string()},
               {"weights_sha1", hash},
               {"ensemble", policy.members.size()},
               {"hidden", hidden},
               {"activation", "tanh"},
               {"period_s", policy.period},
               {"history", {{"samples", policy.samples}, {"spacing_periods", policy.spacing}}},
               {"inputs", inputs},
               {"outputs", outputs},
               {"limits",
                {{"speed_m_s", policy.speed_limit},
                 {"lowest_log_sd", kLowestLogSd},
                 {"highest_log_sd", kHighestLogSd}}},
               {"reaction_time_s", p.reaction_time},
               {"training", {{"input_noise", p.input_noise}, {"weight_decay", p.weight_decay}}},
               {"trained_on", to_json(p.trained_on)},
               {"metrics",
                {{"members", training},
                 {"residual_m_s", p.residual},
                 {"held_out_residual_m_s", number_or_null(p.held_out_residual)},
                 {"dagger", rounds}}}};
  if (!policy.memories.empty()) json["memory"] = policy.memories.front().units();
  // The weights first, under a name of their own: until the rename of `file` the controller of
  // before is whole, and from then on this one.
  WrittenFile written_weights(weights.string(), bytes);
  WrittenFile written(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  written_weights.commit();
  written.commit();
  remove_old_weights(file);
}

PolicyFile read_policy(const std::string& file) {
  return read_json(file, [&](const Json& json) { return parse_policy(json, file); });
}

PolicyFile parse_policy(const Json& json, const std::string& file) {
  JsonFields fields(json, file);
  PolicyFile p;
  expect_heading(fields, "torch", 1);
  fields.choice("activation", {"tanh"});
  const std::size_t memory = read_signature(fields, p.policy);
  p.reaction_time = fields.number("reaction_time_s", rule::not_negative());
  JsonFields training = fields.object("training");
  p.input_noise = training.number("input_noise", rule::not_negative());
  p.weight_decay = training.number("weight_decay", rule::not_negative());
  training.finish();
  p.trained_on = read_trained_on(fields, file);
  read_metrics(fields.object("metrics"), p);
  const std::vector<std::size_t> widths = read_widths(fields, p.policy, memory);
  const std::string name = fields.text("weights"), hash = fields.text("weights_sha1");
  if (name.empty() || name == "." || name == ".." || name.find('/') != name.npos ||
      name.find('\0') != name.npos)
    fields.refuse("weights", "must be the name of a file in the same folder");
  fields.finish();

  const std::string weights = (fs::path(file).parent_path() / name).string();
  const std::string bytes = read_weights(weights);
  from_tensors(parse_safetensors(bytes, weights), widths, weights, p.policy);
  if (sha1(bytes) != hash)
    throw BadInput(weights + ": is not the file that " + file + " was written with (weights_sha1)");
  return p;
}

}  // namespace ferrule
