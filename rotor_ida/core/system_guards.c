/* What ends the mode of a contact of a rotor system: each mode has guards, series that are above 0
 * while it lasts. The gap falls to 0 at an entry, the root of the indentation at an exit; the
 * factor of contact damping at a release, and its negative at a press; and the slip, or the grip
 * that is left to a rolling contact, where it begins to roll or to slip. What follows is decided in
 * system_contact.c. */
#include "system_work.h"

/* Error of a displacement after some steps, in parts of their tolerance. */
static const double SLACK = 10.0;
/* Below this part of the largest grip of the contact, the force that rolling needs is lost in
 * rounding. */
static const double HIDDEN = 1e-12;

static double guard_of_gap(const struct work *work, const struct touching *each, double step)
{
    double gap[GAP_TERMS], x[ORDERS] = {0.0}, y[ORDERS] = {0.0};
    const int order = work->order;
    for (int n = 0; n <= order; n++) {
        x[n] = each->series.terms[n][ELEMENT_X];
        y[n] = each->series.terms[n][ELEMENT_Y];
    }
    /* the whole product: cut off at the order it would be less exact than its factors */
    write_product(order, 2 * order, x, x, y, y, gap);
    for (int n = 0; n <= 2 * order; n++)
        gap[n] = (n == 0 ? each->law->clearance * each->law->clearance : 0.0) - gap[n];
    /* beyond the stator by an error of the step, and on the way from it: it has just left */
    const double clearance = each->law->clearance;
    const double apart = 2.0 * clearance * clearance * fmax(PASSED, SLACK * work->run->rtol);
    if (gap[0] < 0.0 && gap[0] >= -apart && gap[1] > 0.0)
        gap[0] = 0.0;
    return first_fall(gap, 1, 2 * order, step, each->touch->zeros[OF_ROOT]);
}

static double guard_of_release(const struct work *work, const struct touching *each, double step)
{
    double factor[ORDERS];
    const double sign = pushes(each) ? 1.0 : -1.0;
    for (int n = 0; n <= work->order; n++)
        factor[n] = sign * element_factor(&each->element, n, each->answers[n][ELEMENT_APPROACH]);
    return first_fall(factor, 1, work->order, step, each->touch->zeros[OF_RELEASE]);
}

static double guard_of_slip(const struct work *work, const struct touching *each, double step)
{
    double left[ORDERS];
    if (each->touch->mode != ROLLS) {
        for (int n = 0; n <= work->order; n++)
            left[n] = each->touch->sense * each->answers[n][ELEMENT_SLIP];
        return first_fall(left, 1, work->order, step, each->touch->zeros[OF_SLIP]);
    }
    double first = INFINITY, size = 0.0, pressed = 0.0, scale = 1.0;
    for (int n = 0; n < work->order; n++) {
        size += fabs(each->drag[n]) * scale;
        pressed += fabs(each->answers[n][ELEMENT_PUSH]) * scale;
        scale *= step;
    }
    const double largest = fmax(work->run->open[each - work->touching].hardest.value, pressed);
    if (size <= fmax(HIDDEN * each->law->friction * largest, each->hidden))
        return INFINITY;
    for (int side = 0; side < 2; side++) {
        for (int n = 0; n < work->order; n++)
            left[n] = grip_of(each, n) - (side ? -1.0 : 1.0) * each->drag[n];
        /* on a stator without mass it has just begun, at this limit */
        const int zeros = (each->touch->sense < 0.0) == side ? each->touch->zeros[OF_SLIP] : 0;
        first = smaller(first, first_fall(left, 1, work->order - 1, step, zeros));
    }
    return first;
}

struct happening first_happening(struct work *work, double step)
{
    struct happening first = {INFINITY, -1, OF_ROOT};
    for (int i = 0; i < (int)work->run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        double points[GUARDS] = {INFINITY, INFINITY, INFINITY};
        if (!is_touching(each)) {
            points[OF_ROOT] = guard_of_gap(work, each, step);
        } else if (!is_centred(each)) {
            points[OF_ROOT] = first_fall(&each->series.terms[0][ELEMENT_ROOT], WIDTH, work->order,
                                         step, each->touch->zeros[OF_ROOT]);
            if (each->law->contact_damping > 0.0)
                points[OF_RELEASE] = guard_of_release(work, each, step);
            if (each->law->friction > 0.0 && pushes(each))
                points[OF_SLIP] = guard_of_slip(work, each, step);
        }
        for (int guard = 0; guard < GUARDS; guard++) {
            if (points[guard] < first.point)
                first = (struct happening){points[guard], i, guard};
        }
        if (first.point < step) /* no other is looked for beyond it */
            step = first.point;
    }
    return first;
}
