// number.h - numbers as text, the same in every locale.
//
// number = ["-" / "+"] digits ["." digits] [("e" / "E") ["-" / "+"] digits]
// and nothing else: no blanks, no hexadecimal, no inf or nan, and a digit on
// both sides of the point.  What overflows a double is refused; what underflows
// becomes the nearest double, which may be 0.
// Thread: any (no shared state).
#ifndef PROTOCOL_NUMBER_H
#define PROTOCOL_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "protocol/bytes.h"

#define NUMBER_TEXT_MAX 128 // longest text that is read as one number, bytes
#define NUMBER_BUFFER 32    // holds any number printed here, with its NUL

// The whole of `text` as a finite double, correctly rounded.
bool number_parse(struct span text, double *out);

// The whole of `text` as digits only, at most `max`.
bool number_parse_u64(struct span text, uint64_t max, uint64_t *out);

// The decimal with the fewest significant digits that number_parse reads back
// as the same float (after rounding to float) or double; without an exponent
// from 1e-6 up to below 1e21.  `value` is finite.  -0 prints "-0".  Both return
// the length.
size_t number_print_float(char out[NUMBER_BUFFER], float value);
size_t number_print(char out[NUMBER_BUFFER], double value);

#endif
