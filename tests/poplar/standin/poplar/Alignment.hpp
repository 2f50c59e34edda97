// A stand-in for the header of the same name in the Poplar SDK. Instructions of a worker begin at multiples of 8 bytes on
// an IPU; on a host the attribute says nothing.
#pragma once

#define WORKER_ALIGN
