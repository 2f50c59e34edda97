// A stand-in for the header of the same name in the Poplar SDK: the vector layouts that a target has.
#pragma once

#define VECTOR_AVAIL_SHORT_SPAN 1
#define VECTOR_AVAIL_SCALED_PTR32 1
#define VECTOR_AVAIL_SCALED_PTR64 1
#define VECTOR_AVAIL_SCALED_PTR128 1
#define VECTORLIST_AVAIL_DELTAN 1
#define VECTORLIST_AVAIL_DELTANELEMENTS 1
