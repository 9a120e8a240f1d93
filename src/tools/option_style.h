// How the programs read their command lines.
#pragma once

#include <boost/program_options/cmdline.hpp>

namespace ratslam {

/// Options by their full names: a name that was a beginning of one option alone may be that of two in another version.
constexpr int kOptionStyle = boost::program_options::command_line_style::default_style ^
                             boost::program_options::command_line_style::allow_guessing;

}  // namespace ratslam
