#include "controller/joint_loss.hpp"

#include "tests/compare.hpp"

namespace ferrule {
namespace {

TEST(JointLoss, HasTheValueAt15Digits) {
  EXPECT_CLOSE(joint_loss_dB(0.5e-6, 5e-3), 0.0661516783327908, 1e-13);
}

TEST(JointLoss, IsZeroForAPerfectJointAndAdds) {
  EXPECT_EQ(joint_loss_dB(0, 0), 0);
  EXPECT_CLOSE(joint_loss_dB(1e-6, 2e-3), joint_loss_dB(1e-6, 0) + joint_loss_dB(0, 2e-3), 1e-14);
}

}  // namespace
}  // namespace ferrule
