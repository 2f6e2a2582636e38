#include "capture/force_history.hpp"

#include "insertion/scene_scaling.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// Rows of forces that are known; at rest in the first.
class Recording {
 public:
  explicit Recording(const Scene& scene, int rows) : scene_(scene) {
    episode_.rows = Rows::Zero(rows, kRowSize);
    for (int n = 0; n < rows; ++n) episode_.rows(n, kTime.begin) = 1e-3 * n;
  }
  // Sets the force of a term [uN]; what holds the fibre is their sum.
  Recording& force(int row, Term term, const Vector3d& uN) {
    episode_.rows.row(row).segment<3>(force_column(term)) = 1e-6 * uN.transpose();
    episode_.rows.row(row).segment<3>(kHolder.begin) += 1e-6 * uN.transpose();
    return *this;
  }
  Recording& touch(int row) {
    episode_.rows(row, state_column("end_closed")) = 1;
    return *this;
  }
  ForceHistory history() const { return force_history(episode_, scene_); }
  InsertionForces forces() const { return {episode_, scene_}; }
  TermActivity of(Term term) const {
    for (const TermActivity& t : history().terms)
      if (t.term == term) return t;
    throw std::runtime_error("not there");
  }

 private:
  const Scene& scene_;
  Episode episode_;
};

TEST(ForceHistory, TellsWhenATermActs) {
  const Scene scene = testing::paper();
  Recording r(scene, 10);
  r.touch(8).touch(9);
  r.force(3, Term::electrostatic, {0, -3, 0}).force(4, Term::electrostatic, {0, 0, 1});
  r.force(9, Term::electrostatic, {0, 4, 3});
  const TermActivity t = r.of(Term::electrostatic);
  EXPECT_CLOSE(t.acts, 0.3, 1e-12);
  EXPECT_CLOSE(t.apart, 2.0 / 8, 1e-12);
  EXPECT_CLOSE(t.touching, 1.0 / 2, 1e-12);
  EXPECT_CLOSE(t.first, 3e-3, 1e-12);
  EXPECT_CLOSE(t.last, 9e-3, 1e-12);
  EXPECT_CLOSE(t.median, 3e-6, 1e-12);
  EXPECT_CLOSE(t.largest, 5e-6, 1e-12);
  EXPECT_CLOSE(t.reaches, 1, 1e-12);
  EXPECT_CLOSE(t.of_felt, 1, 1e-12);
  EXPECT_CLOSE(r.history().touching, 0.2, 1e-12);
  EXPECT_CLOSE(r.history().felt_largest, 5e-6, 1e-12);
  const TermActivity never = r.of(Term::capillary);
  EXPECT_EQ(never.acts, 0);
  EXPECT_EQ(never.largest, 0);
  EXPECT_TRUE(std::isnan(never.first));
  EXPECT_TRUE(std::isnan(never.reaches));
}

// The wall holds the adhesion; only what the wall has more is felt.
TEST(ForceHistory, WhatTheWallHoldsDoesNotReachTheHand) {
  const Scene scene = testing::paper();
  Recording r(scene, 2);
  r.touch(1).force(1, Term::adhesion, {0, 7, 0}).force(1, Term::wall, {0, -10, 0});
  EXPECT_EQ(r.of(Term::adhesion).reaches, 0);
  EXPECT_CLOSE(r.of(Term::wall).reaches, 0.3, 1e-12);
  EXPECT_CLOSE(r.of(Term::wall).of_felt, 1, 1e-12);
  EXPECT_EQ(r.of(Term::adhesion).noticed, 0);
  EXPECT_CLOSE(r.of(Term::wall).noticed, 0.5, 1e-12);
}

TEST(ForceHistory, WeightAtRestIsNotFelt) {
  const Scene scene = testing::paper();
  Recording r(scene, 3);
  for (int n = 0; n < 3; ++n) r.force(n, Term::gravity, {0, -1.4, 0});
  r.force(2, Term::friction, {0.5, 0, 0});
  EXPECT_EQ(r.of(Term::gravity).acts, 1);
  EXPECT_EQ(r.of(Term::gravity).reaches, 0);
  EXPECT_CLOSE(r.of(Term::friction).reaches, 1, 1e-12);
}

// 0.1 N at the hand, and a tenth of what is felt.
TEST(ForceHistory, IsNoticedFromAJustNoticeableDifferenceOn) {
  const Scene scene = testing::paper();
  const double least = 1e6 * kNoticedForce / scene_scaling(scene).force;  // [uN]
  for (const auto& [friction, electrostatic, noticed] :
       std::vector<std::tuple<double, double, bool>>{
           {0, 0.99 * least, false},
           {0, 1.01 * least, true},
           {0.88 * 20 * least, 0.12 * 20 * least, true},
           {0.92 * 20 * least, 0.08 * 20 * least, false}}) {
    Recording r(scene, 2);
    r.force(1, Term::friction, {friction, 0, 0})
        .force(1, Term::electrostatic, {electrostatic, 0, 0});
    EXPECT_EQ(r.of(Term::electrostatic).noticed, noticed ? 0.5 : 0) << friction;
  }
}

// All rows weigh alike, each insertion is felt relative to its own rest, and an insertion without
// rows says nothing.
TEST(ForceHistory, OfSeveralInsertionsIsThatOfTheirRows) {
  const Scene scene = testing::paper();
  Recording one(scene, 10), two(scene, 30), three(scene, 10);
  for (int n = 0; n < 10; ++n) one.force(n, Term::gravity, {0, -1.4, 0});
  one.force(4, Term::friction, {2, 0, 0});
  for (int n = 10; n < 30; ++n) two.touch(n).force(n, Term::friction, {4, 0, 0});
  three.touch(9).force(9, Term::friction, {0, 7, 0});
  const ForceHistory all =
      force_history({one.forces(), two.forces(), InsertionForces(scene), three.forces()});
  EXPECT_EQ(all.insertions, 3);
  EXPECT_CLOSE(all.touching, 21.0 / 50, 1e-12);
  EXPECT_CLOSE(all.felt_largest, 7e-6, 1e-12);
  for (const TermActivity& t : all.terms) {
    if (t.term == Term::gravity) {
      EXPECT_CLOSE(t.acts, 0.2, 1e-12);
      EXPECT_EQ(t.reaches, 0);
    }
    if (t.term != Term::friction) continue;
    EXPECT_CLOSE(t.acts, 22.0 / 50, 1e-12);
    EXPECT_CLOSE(t.apart, 1.0 / 29, 1e-12);
    EXPECT_CLOSE(t.touching, 1, 1e-12);
    EXPECT_CLOSE(t.first, 9e-3, 1e-12);
    EXPECT_CLOSE(t.last, 9e-3, 1e-12);
    EXPECT_CLOSE(t.median, 4e-6, 1e-12);
    EXPECT_CLOSE(t.largest, 7e-6, 1e-12);
    EXPECT_CLOSE(t.of_felt, 1, 1e-12);
  }
  const ForceHistory none = force_history({InsertionForces(scene)});
  EXPECT_EQ(none.insertions, 0);
  EXPECT_TRUE(std::isnan(none.touching));
}

// In a quasi-static insertion the parts make up all that is felt.
TEST(ForceHistory, OfAnInsertionSharesOutWhatIsFelt) {
  const Scene scene = load_scene("bench");
  const State start = draw_start(scene, 1, 2);
  Episode episode;
  episode.rows =
      testing::record_rows(scene, start, *simulated_operator(testing::setup(scene, 2), 0.8))
          .matrix();
  double sum = 0;
  for (const TermActivity& t : force_history(episode, scene).terms) {
    if (t.acts == 0) continue;
    EXPECT_GE(t.reaches, 0);
    EXPECT_LE(t.reaches, 1 + 1e-9);
    sum += t.of_felt;
  }
  EXPECT_CLOSE(sum, 1, 1e-3);
}

}  // namespace
}  // namespace ferrule
