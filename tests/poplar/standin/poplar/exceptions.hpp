#pragma once
#include "../host.hpp"
