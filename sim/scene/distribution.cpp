#include "sim/scene/distribution.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

constexpr std::array kKinds = {"normal", "uniform", "lognormal", "choice"};
constexpr double kCut = 3;  // standard deviations

double cut_normal(RandomStream& random) noexcept {
  double deviation = random.normal();
  while (std::abs(deviation) > kCut) deviation = random.normal();
  return deviation;
}

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || read.ec != std::errc() || read.ptr != text.data() + text.size())
    return std::nullopt;
  return value;
}

Json uniform_within(double low, double high) {
  return {{"uniform", {as_written(low), as_written(high)}}};
}

}  // namespace

Json as_written(double x) {
  return x == std::round(x) && std::abs(x) < 1e15 ? Json(std::llround(x)) : Json(x);
}

std::optional<Distribution> Distribution::read(const Json& value) {
  if (!value.is_object() || value.size() != 1) return std::nullopt;
  const auto kind = std::find(kKinds.begin(), kKinds.end(), value.begin().key());
  if (kind == kKinds.end()) return std::nullopt;
  const Json& list = value.front();
  const bool pair = kind != kKinds.end() - 1;
  std::vector<double> numbers;
  if (list.is_array())
    for (const Json& x : list)
      if (x.is_number() && std::isfinite(x.get<double>())) numbers.push_back(x);
  const bool numeric = list.is_array() && numbers.size() == list.size();
  const Distribution read(static_cast<Kind>(kind - kKinds.begin()), numbers);
  if (!pair) {
    if (!numeric || numbers.empty()) throw BadInput("must be {\"choice\": [number, ...]}");
    return read;
  }
  const bool two = numeric && numbers.size() == 2;
  if (read.kind_ == uniform && !(two && numbers[0] <= numbers[1]))
    throw BadInput("must be {\"uniform\": [low, high]}, low <= high");
  if (read.kind_ == normal && !(two && numbers[1] >= 0))
    throw BadInput("must be {\"normal\": [mean, standard deviation]}, the latter >= 0");
  if (read.kind_ == lognormal && !(two && numbers[0] > 0 && numbers[1] >= 0))
    throw BadInput("must be {\"lognormal\": [median, spread]}, median > 0, spread >= 0");
  return read;
}

double Distribution::draw(RandomStream& random) const noexcept {
  const double a = numbers_.front();
  switch (kind_) {
    case normal:
      return a + numbers_[1] * cut_normal(random);
    case uniform:
      return a + (numbers_[1] - a) * random.uniform();
    case lognormal:
      return a * elementary::exp(numbers_[1] * cut_normal(random));
    case choice:
      return numbers_[random.bits() % numbers_.size()];
  }
  return a;
}

double Distribution::centre() const noexcept {
  return kind_ == uniform ? (numbers_[0] + numbers_[1]) / 2 : numbers_.front();
}

std::vector<double> Distribution::extremes() const {
  const double a = numbers_.front();
  switch (kind_) {
    case normal:
      return {a - kCut * numbers_[1], a + kCut * numbers_[1]};
    case lognormal:
      return {a * elementary::exp(-kCut * numbers_[1]), a * elementary::exp(kCut * numbers_[1])};
    default:
      return numbers_;
  }
}

std::optional<Json> distribution_of(std::string text) {
  std::erase(text, ' ');
  const auto dots = text.find(".."), sign = text.find("+-"), slash = text.find("/-");
  const auto plus = text.find('+');
  if (dots != text.npos) {
    const auto low = number(text.substr(0, dots)), high = number(text.substr(dots + 2));
    if (!low || !high || !(*low <= *high)) return std::nullopt;
    return uniform_within(*low, *high);
  }
  if (sign != text.npos) {
    const auto middle = number(text.substr(0, sign)), most = number(text.substr(sign + 2));
    if (!middle || !most || !(*most >= 0)) return std::nullopt;
    return Json{{"normal", {as_written(*middle), as_written(*most / kCut)}}};
  }
  if (plus == text.npos || slash == text.npos || slash < plus) return std::nullopt;
  const auto nominal = number(text.substr(0, plus));
  const auto above = number(text.substr(plus + 1, slash - plus - 1));
  const auto below = number(text.substr(slash + 2));
  if (!nominal || !above || !below || !(*above >= 0 && *below >= 0)) return std::nullopt;
  return uniform_within(*nominal - *below, *nominal + *above);
}

}  // namespace ferrule
