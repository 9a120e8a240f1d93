/// Parameters of the pose cells: size of the network, attractor kernels (eqs. (1), (2)), view cell input (eq.
/// (3)), experience selection (eq. (5)). Defaults are OpenRatSLAM's.
#pragma once

#include "ratslam/common/params.h"

namespace ratslam {

struct PoseCellParams {
  int n_xy = 21;           ///< cells along x and along y (N)
  int n_th = 36;           ///< heading layers (M)
  double cell_size = 1.0;  ///< edge of a cell [m]
  int excitation_dim = 7;  ///< side of the excitation kernel [cells], odd
  int inhibition_dim = 5;  ///< side of the inhibition kernel [cells], odd
  // The four are standard deviations, although OpenRatSLAM's keys call them variances.
  double excitation_var = 1.0;      ///< k_p of the excitation, along x and y [cells]
  double inhibition_var = 2.0;      ///< k_p of the inhibition, along x and y [cells]
  double excitation_var_th = 0.0;   ///< k_d of the excitation, along heading [layers]; 0: as excitation_var
  double inhibition_var_th = 0.0;   ///< k_d of the inhibition, along heading [layers]; 0: as inhibition_var
  double global_inhibition = 2e-5;  ///< phi of eq. (2), taken from every cell
  double inject_energy = 0.15;      ///< activity that a recalled view adds while it is not saturated
  bool openratslam_injection = false;  ///< that goes to one cell: the coordinates of the tie, truncated
  double active_decay = 1.0;       ///< saturation of a rested view cell, and its growth with each repetition
  double restore = 0.05;           ///< saturation that every view cell loses at each view event
  bool openratslam_corner = true;  ///< path integration treats the plane's corner as OpenRatSLAM does
  double experience_distance = 2.0;  ///< distance of the peak beyond which the place is another one [cells]
  double experience_density = 0.0;   ///< k: how fast that distance shrinks with visits; 0: it is constant

  /// Standard deviation of the excitation along heading, 0 resolved [layers].
  double excitationVarTh() const { return excitation_var_th > 0.0 ? excitation_var_th : excitation_var; }
  /// Standard deviation of the inhibition along heading, 0 resolved [layers].
  double inhibitionVarTh() const { return inhibition_var_th > 0.0 ? inhibition_var_th : inhibition_var; }

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("pc_dim_xy", n_xy, Bounds{1, 4096}, "pose cells along x and y");
    visit("pc_dim_th", n_th, Bounds{1, 4096}, "pose cells along the heading (layers)");
    visit("pc_cell_x_size", cell_size, Bounds{1e-9, 1e9}, "edge of a pose cell [m]");
    visit("pc_w_e_dim", excitation_dim, Bounds{1, 101}, "side of the excitation kernel, odd [cells]");
    visit("pc_w_i_dim", inhibition_dim, Bounds{1, 101}, "side of the inhibition kernel, odd [cells]");
    visit("pc_w_e_var", excitation_var, Bounds{1e-3, 1e6},
          "standard deviation of the excitation kernel along x and y [cells]");
    visit("pc_w_i_var", inhibition_var, Bounds{1e-3, 1e6},
          "standard deviation of the inhibition kernel along x and y [cells]");
    visit("pc_w_e_var_th", excitation_var_th, Bounds{0, 1e6},
          "standard deviation of the excitation kernel along the heading [layers]; 0: as pc_w_e_var");
    visit("pc_w_i_var_th", inhibition_var_th, Bounds{0, 1e6},
          "standard deviation of the inhibition kernel along the heading [layers]; 0: as pc_w_i_var");
    visit("pc_global_inhib", global_inhibition, Bounds{0, 1},
          "global inhibition: activity taken from every cell");
    visit(
        "pc_openratslam_corner", openratslam_corner, Bounds{},
        "lose the activity that enters a corner cell of the plane across one edge only, as OpenRatSLAM does");
    visit("pc_vt_inject_energy", inject_energy, Bounds{0, 1e3}, "activity that a recalled view adds");
    visit("pc_openratslam_injection", openratslam_injection, Bounds{},
          "add it to one cell, whose numbers are the position of the view cell without its fractions, as "
          "OpenRatSLAM does; false: divide it among the cells around that position");
    visit("vt_active_decay", active_decay, Bounds{0, 1e3}, "saturation of a rested view cell and its growth");
    visit("pc_vt_restore", restore, Bounds{0, 1e3}, "saturation lost at each view event");
    visit("exp_delta_pc_threshold", experience_distance, Bounds{0, 1e6},
          "distance of the peak from an experience beyond which the place is another one [cells]");
    visit("exp_density", experience_density, Bounds{0, 100},
          "k: after n visits of a place that distance is exp_delta_pc_threshold / (1 + k ln(1 + n)); 0: it "
          "is constant");
  }

  /// @throws std::invalid_argument naming key, value and requirement.
  void validate() const;
};

}  // namespace ratslam
