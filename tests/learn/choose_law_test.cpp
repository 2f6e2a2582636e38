#include "learn/choose_law.hpp"

#include "tests/compare.hpp"
#include "tests/law_episodes.hpp"

namespace ferrule {
namespace {

using testing::kScales;
using testing::law_episodes;
using testing::usual_law;

// Is `inner` a special case of `outer`?
bool contains(LawKind outer, LawKind inner) {
  return outer == inner || inner == LawKind::linear ||
         (outer == LawKind::saturated && inner == LawKind::phased) ||
         (outer == LawKind::guarded && inner == LawKind::insertion);
}

LawKind chosen(const Law& law, double noise, std::uint64_t seed) {
  return simplest_within_one_standard_error(
      cross_validate(law_episodes(law, 6, 300, noise, seed), kScales));
}

TEST(ChooseLawAtLength, FindsTheLawThatMadeTheData) {
  for (const LawKind kind : kLaws)
    for (std::uint64_t seed = 1; seed <= 2; ++seed)
      EXPECT_EQ(name(chosen(usual_law(kind), 1e-4, seed)), name(kind)) << seed;
}

// With noise as large as what tells the laws apart it may settle for a simpler one, never for one
// that the data do not call for.
TEST(ChooseLawAtLength, NeverTakesAWiderLawThanTheTruth) {
  int simpler = 0;
  for (const LawKind kind : kLaws)
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const LawKind taken = chosen(usual_law(kind), 3e-3, seed);
      EXPECT_TRUE(contains(kind, taken)) << name(kind) << ", taken " << name(taken);
      simpler += taken != kind;
    }
  EXPECT_GT(simpler, 0);
}

TEST(ChooseLaw, TakesTheFewestGainsWithinOneStandardError) {
  const auto rule = [](double linear, double insertion, double phased, double error) {
    return simplest_within_one_standard_error({{LawKind::linear, linear, 0.5},
                                               {LawKind::insertion, insertion, error},
                                               {LawKind::phased, phased, error},
                                               {LawKind::saturated, NAN, NAN}});
  };
  EXPECT_EQ(rule(1.05, 1.0, 1.1, 0.1), LawKind::linear);
  EXPECT_EQ(rule(1.15, 1.0, 1.1, 0.1), LawKind::insertion);
  EXPECT_EQ(rule(1.15, 1.05, 1.0, 0.1), LawKind::insertion);
  EXPECT_EQ(rule(1.15, 1.05, 1.0, 0.01), LawKind::phased);
  EXPECT_EQ(rule(NAN, 1.05, 1.0, 0.1), LawKind::insertion);
  EXPECT_THROW(rule(NAN, NAN, NAN, 0.1), BadInput);
}

// The error of a law is that of a prediction: on data that are noise alone it is the noise, and no
// better for a law with more gains.
TEST(ChooseLawAtLength, ErrorsAreOfEpisodesThatWereNotFitted) {
  const double noise = 5e-4;
  const auto data =
      law_episodes(Law(LawKind::linear, {-2e-3, 0, 0, 0, 1e-3, 1e-3}), 10, 400, noise, 7);
  const auto laws = cross_validate(data, kScales);
  ASSERT_EQ(laws.size(), kLaws.size());
  for (const CrossValidated& law : laws) {
    EXPECT_GT(law.standard_error, 0);
    EXPECT_GT(law.error, std::sqrt(3) * noise - 4 * law.standard_error) << name(law.kind);
  }
  EXPECT_LT(laws[0].error, std::sqrt(3) * noise + 4 * laws[0].standard_error);
  EXPECT_GT(laws[3].error, laws[0].error);
}

}  // namespace
}  // namespace ferrule
