// A light as convection carries it through the cells of a light volume.
struct CarriedLight {
    float4 place; // point: position in cells from the box's low corner; directional: unit direction of travel;
                  // w: largest squared distance, in cells, at which a cell keeps the mean of the light in it;
                  // below 0 where none does
    float4 power; // point: intensity in W/sr over local units squared; directional: irradiance;
                  // w: the least squared distance from which a point is seen, local units squared
    int4 cell;    // the cell that light comes from: -1 before the box, the number of cells behind it; w: 1 for points
};
