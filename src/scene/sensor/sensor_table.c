// Every type of camera. A new one is a file and a line here.
#include "scene/sensor.h"

extern const struct sensor_type sensor_perspective, sensor_thinlens, sensor_orthographic;

const struct sensor_type *const sensor_table[] = {&sensor_perspective, &sensor_thinlens, &sensor_orthographic, NULL};
