// A stand-in for the header of the same name in the Poplar SDK: the few constants that public codelets use.
#pragma once

#define CTXT_WORKERS 6              // worker contexts of a tile
#define CTXT_TOTAL 7                // worker contexts and the supervisor
#define TMEM_BYTE_MAX_ADDRESS_WIDTH 21 // bits of a tile address: 624 KiB from 0x4c000
#define TMEM_REGION0_BASE_ADDR 0x4c000
