// Functions of inner loops are inlined by force: CPU compilers otherwise call them and pass their state through memory.
#define INLINE inline __attribute__((always_inline))
