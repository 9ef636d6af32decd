// Functions of inner loops are inlined by force: CPU compilers otherwise call them and pass their state through memory.
// Interpreters that cannot bear it are given another definition.
#ifndef INLINE
#define INLINE inline __attribute__((always_inline))
#endif
