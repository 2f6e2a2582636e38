#include "view/message.hpp"

#include <gtest/gtest.h>

#include "sim/base/error.hpp"

namespace ferrule {
namespace {

TEST(Message, SaysWhatAPageSaid) {
  const auto hand = std::get<HandMessage>(
      parse_message(R"({"type":"hand","v":[-0.5,0,3],"buttons":2,"seq":7,"t":12.5})"));
  EXPECT_EQ(hand.velocity, (std::array<double, 3>{-0.5, 0, 1}));
  EXPECT_EQ(hand.buttons, 2u);
  EXPECT_EQ(hand.sequence, 7u);
  EXPECT_EQ(std::get<RateMessage>(parse_message(R"({"type":"rate","stars":4})")).stars, 4);
  const auto fit =
      std::get<FitMessage>(parse_message(R"({"type":"fit","episodes":["a.h5","b.h5"]})"));
  EXPECT_EQ(fit.episodes, (std::vector<std::string>{"a.h5", "b.h5"}));
  EXPECT_TRUE(std::get<FitMessage>(parse_message(R"({"type":"fit"})")).episodes.empty());
  const auto but = std::get<FitMessage>(parse_message(R"({"type":"fit","but":["c.h5"]})"));
  EXPECT_TRUE(but.episodes.empty());
  EXPECT_EQ(but.but, std::vector<std::string>{"c.h5"});
  EXPECT_TRUE(std::holds_alternative<StartMessage>(parse_message(R"({"type":"start"})")));
  EXPECT_TRUE(std::holds_alternative<StopMessage>(parse_message(R"({"type":"stop"})")));
  EXPECT_TRUE(std::holds_alternative<DiscardMessage>(parse_message(R"({"type":"discard"})")));
  EXPECT_TRUE(std::holds_alternative<InsertMessage>(parse_message(R"({"type":"insert"})")));
  for (const std::string name : {"", "Ada Løvelace", "=1+1"})
    EXPECT_EQ(
        std::get<TraineeMessage>(parse_message(R"({"type":"trainee","name":")" + name + R"("})"))
            .name,
        name);
}

TEST(Message, EverythingElseIsRefused) {
  for (const char* bad : {"",
                          "{",
                          "null",
                          "[]",
                          "7",
                          R"("start")",
                          "{}",
                          R"({"type":7})",
                          R"({"type":"open"})",
                          R"({"type":"hand"})",
                          R"({"type":"hand","v":[1,2]})",
                          R"({"type":"hand","v":[1,2,"x"]})",
                          R"({"type":"hand","v":[1e999,0,0]})",
                          R"({"type":"hand","v":[0,0,0],"seq":-1})",
                          R"({"type":"hand","v":[0,0,0],"buttons":4294967296})",
                          R"({"type":"rate"})",
                          R"({"type":"rate","stars":0})",
                          R"({"type":"rate","stars":6})",
                          R"({"type":"rate","stars":2.5})",
                          R"({"type":"fit","episodes":"all"})",
                          R"({"type":"fit","episodes":[1]})",
                          R"({"type":"fit","but":"all"})",
                          R"({"type":"fit","but":[["a.h5"]]})",
                          R"({"type":"trainee"})",
                          R"({"type":"trainee","name":7})",
                          R"({"type":"trainee","name":"two\nlines"})",
                          R"({"type":"trainee","name":"\u001b[31m"})",
                          "{\"type\":\"\xff\"}"})
    EXPECT_THROW(parse_message(bad), BadInput) << bad;
  const std::string name(kMostName + 1, 'x');
  EXPECT_THROW(parse_message(R"({"type":"trainee","name":")" + name + R"("})"), BadInput);
  const std::string deep(kMostMessage, '[');
  EXPECT_THROW(parse_message(deep), BadInput);
  std::string longer = R"({"type":"start"})";
  longer.resize(kMostMessage + 1, ' ');
  EXPECT_THROW(parse_message(longer), BadInput);
  longer.pop_back();
  EXPECT_NO_THROW(parse_message(longer));
}

}  // namespace
}  // namespace ferrule
