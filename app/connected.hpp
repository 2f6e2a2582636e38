// How the verbs show a device that is connected: `devices` and `doctor`.
#pragma once

#include "haptic/hid/device_list.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

// {"path", "id", "name", "kind", "state"}; of one that is unusable also the "reason", of one that
// is forbidden what mends that, "udev_rule" and "command".
Json device_json(const FoundDevice& device);

}  // namespace ferrule
