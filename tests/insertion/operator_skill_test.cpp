#include "insertion/operator_skill.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sim/base/error.hpp"

namespace ferrule {
namespace {

TEST(OperatorSkill, IsWhatItsTextSays) {
  const OperatorSkill skill = OperatorSkill::parse("0.30,bore_yield=2.5,tremor=1e-6");
  TraineeTraits same = trainee_traits(0.3);
  same.bore_yield = 2.5;
  same.tremor = 1e-6;
  for (const Trait& trait : kTraits)
    EXPECT_EQ(skill.traits().*trait.value, same.*trait.value) << trait.name;
  EXPECT_EQ(skill.text(), "0.3,bore_yield=2.5,tremor=1e-06");
  EXPECT_EQ(skill.own(), (std::vector<std::string>{"bore_yield", "tremor"}));
  // The name of a recording's operator tells all of it.
  const auto again = SimulatedOperator::named(SimulatedOperator{skill}.name());
  ASSERT_TRUE(again);
  EXPECT_EQ(again->skill.text(), skill.text());
  EXPECT_EQ(again->skill.traits().bore_yield, 2.5);
}

TEST(OperatorSkill, EachTraitHasANameAndARange) {
  for (const Trait& trait : kTraits)
    for (const double value : {trait.low, trait.high}) {
      const std::string text = fmt::format("0.5,{}={}", trait.name, value);
      EXPECT_EQ(OperatorSkill::parse(text).traits().*trait.value, value) << text;
      for (const double skill : {0.0, 1.0}) {
        EXPECT_GE(trainee_traits(skill).*trait.value, trait.low) << trait.name;
        EXPECT_LE(trainee_traits(skill).*trait.value, trait.high) << trait.name;
      }
    }
}

TEST(OperatorSkill, WhatIsWrongIsSaid) {
  const auto said = [](const char* text) -> std::string {
    try {
      OperatorSkill::parse(text);
      return "nothing";
    } catch (const BadInput& error) {
      return error.what();
    }
  };
  for (const char* text : {"", "2", "-0.1", "nan", "0.5x", " 0.5"})
    EXPECT_NE(said(text).find("skill = " + std::string(text)), std::string::npos) << said(text);
  EXPECT_NE(said("0.8,bore_yeild=1").find("did you mean bore_yield?"), std::string::npos);
  EXPECT_NE(said("0.8,delay=-1").find("delay = -1: must be a number from 0.001 to 1"),
            std::string::npos);
  EXPECT_NE(said("0.8,delay=").find("delay = :"), std::string::npos);
  EXPECT_NE(said("0.8,delay").find("0.8,TRAIT=VALUE"), std::string::npos);
  EXPECT_NE(said("0.8,").find("0.8,TRAIT=VALUE"), std::string::npos);
  EXPECT_NE(said("0.8,delay=0.1,delay=0.2").find("delay stands there twice"), std::string::npos);
}

}  // namespace
}  // namespace ferrule
