// A stand-in for the header of the same name in the Poplar SDK. On an IPU, instructions of a worker begin at multiples of 8
// bytes. On a host the attribute has no effect.
#pragma once

#define WORKER_ALIGN
