#include "geom/camera.h"
