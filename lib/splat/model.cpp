#include "geom/sphere.h"
