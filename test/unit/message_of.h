// What an action complains of.
#pragma once

#include <stdexcept>
#include <string>

namespace ratslam::test {

/// The words of the error that an action throws; empty where it throws none. Errors of another kind pass through.
template <class Error = std::runtime_error, class Action>
std::string messageOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace ratslam::test
