#include "render/splatter.h"
