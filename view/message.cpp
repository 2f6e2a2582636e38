#include "view/message.hpp"

#include "sim/base/json_fields.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kMostEpisodes = 1000;

std::uint32_t whole_or_zero(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) return 0;
  if (!found->is_number_unsigned() || found->get<std::uint64_t>() > UINT32_MAX)
    throw BadInput(std::string("message: ") + key + ": must be a whole number below 2^32");
  return found->get<std::uint32_t>();
}

HandMessage parse_hand(const Json& json) {
  HandMessage hand{};
  const auto v = json.find("v");
  if (v == json.end() || !v->is_array() || v->size() != hand.velocity.size())
    throw BadInput("message: v: must be three numbers");
  for (std::size_t i = 0; i < hand.velocity.size(); ++i) {
    if (!(*v)[i].is_number()) throw BadInput("message: v: must be three numbers");
    hand.velocity[i] = std::clamp((*v)[i].get<double>(), -1.0, 1.0);
  }
  hand.buttons = whole_or_zero(json, "buttons");
  hand.sequence = whole_or_zero(json, "seq");
  return hand;
}

RateMessage parse_rating(const Json& json) {
  const auto stars = json.find("stars");
  if (stars == json.end() || !stars->is_number_unsigned() || *stars < 1u || *stars > 5u)
    throw BadInput("message: stars: must be from 1 to 5");
  return {stars->get<int>()};
}

std::vector<std::string> file_names(const Json& json, const char* key) {
  std::vector<std::string> names;
  const auto list = json.find(key);
  if (list == json.end()) return names;
  const auto refused = [key] {
    return BadInput(std::string("message: ") + key + ": must be a list of file names");
  };
  if (!list->is_array() || list->size() > kMostEpisodes) throw refused();
  for (const Json& name : *list) {
    if (!name.is_string()) throw refused();
    names.push_back(name);
  }
  return names;
}

}  // namespace

Message parse_message(std::string_view text) {
  if (text.size() > kMostMessage) throw BadInput("message: longer than 4096 bytes");
  const Json json = Json::parse(text, nullptr, false);
  const auto type = json.is_object() ? json.find("type") : json.end();
  if (!json.is_object() || type == json.end() || !type->is_string())
    throw BadInput("message: must be a JSON object with a type");
  const std::string name = *type;
  if (name == "hand") return parse_hand(json);
  if (name == "start") return StartMessage();
  if (name == "stop") return StopMessage();
  if (name == "discard") return DiscardMessage();
  if (name == "rate") return parse_rating(json);
  if (name == "fit") return FitMessage{file_names(json, "episodes"), file_names(json, "but")};
  if (name == "insert") return InsertMessage();
  if (name == "trainee") return TraineeMessage{JsonFields(json, "message").line("name", kMostName)};
  throw BadInput("message: \"" + printable(name, 40) + "\" is no type of message");
}

}  // namespace ferrule
