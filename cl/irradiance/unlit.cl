// What stands for light where a medium shines by its own colours.
#include "common/inline.cl"

struct Lit {
    uint none;
};

INLINE struct Lit no_light(void) {
    struct Lit lit;
    lit.none = 0u;
    return lit;
}
