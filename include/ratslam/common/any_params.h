/// A parameter struct (params.h) of any type. Code can read, list and write it without knowing the type.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

#include "ratslam/common/params.h"

namespace ratslam {

class AnyParams {
 public:
  template <class Params>
  explicit AnyParams(Params params) : held_(std::make_unique<Held<Params>>(std::move(params))) {}
  AnyParams(const AnyParams& other) : held_(other.held_->copy()) {}
  AnyParams& operator=(const AnyParams& other) {
    held_ = other.held_->copy();
    return *this;
  }
  AnyParams(AnyParams&&) = default;
  AnyParams& operator=(AnyParams&&) = default;
  ~AnyParams() = default;

  /// Calls visit(key, value, bounds, meaning) for every field.
  template <class Visitor>
  void visitFields(Visitor&& visit) {
    held_->visit(AnyVisitorOf<Visitor>(visit));
  }
  /// @throws std::invalid_argument as the struct's own validate() does
  void validate() const { held_->validate(); }

  /// The struct. @throws std::bad_cast if it is of another type
  template <class Params>
  const Params& as() const {
    return dynamic_cast<const Held<Params>&>(*held_).params;
  }
  template <class Params>
  bool is() const {
    return dynamic_cast<const Held<Params>*>(held_.get()) != nullptr;
  }

 private:
  /// Visitor with one function for each type that a field may have.
  class AnyVisitor {
   public:
    virtual void field(const std::string& key, bool& value, const Bounds& bounds,
                       const char* meaning) const = 0;
    virtual void field(const std::string& key, int& value, const Bounds& bounds,
                       const char* meaning) const = 0;
    virtual void field(const std::string& key, double& value, const Bounds& bounds,
                       const char* meaning) const = 0;
    virtual void field(const std::string& key, std::string& value, const Bounds& bounds,
                       const char* meaning) const = 0;
    virtual void field(const std::string& key, std::vector<double>& value, const Bounds& bounds,
                       const char* meaning) const = 0;

   protected:
    ~AnyVisitor() = default;
  };

  template <class Visitor>
  class AnyVisitorOf final : public AnyVisitor {
   public:
    explicit AnyVisitorOf(Visitor& visit) : visit_(visit) {}
    void field(const std::string& key, bool& value, const Bounds& bounds,
               const char* meaning) const override {
      visit_(key, value, bounds, meaning);
    }
    void field(const std::string& key, int& value, const Bounds& bounds, const char* meaning) const override {
      visit_(key, value, bounds, meaning);
    }
    void field(const std::string& key, double& value, const Bounds& bounds,
               const char* meaning) const override {
      visit_(key, value, bounds, meaning);
    }
    void field(const std::string& key, std::string& value, const Bounds& bounds,
               const char* meaning) const override {
      visit_(key, value, bounds, meaning);
    }
    void field(const std::string& key, std::vector<double>& value, const Bounds& bounds,
               const char* meaning) const override {
      visit_(key, value, bounds, meaning);
    }

   private:
    Visitor& visit_;
  };

  class Holder {
   public:
    Holder() = default;
    Holder& operator=(const Holder&) = delete;
    virtual ~Holder() = default;
    virtual std::unique_ptr<Holder> copy() const = 0;
    virtual void visit(const AnyVisitor& visitor) = 0;
    virtual void validate() const = 0;

   protected:
    Holder(const Holder&) = default;
  };

  template <class Params>
  class Held final : public Holder {
   public:
    explicit Held(Params held) : params(std::move(held)) {}
    std::unique_ptr<Holder> copy() const override { return std::make_unique<Held>(*this); }
    void visit(const AnyVisitor& visitor) override {
      params.visitFields([&visitor](const std::string& key, auto& value, const Bounds& bounds,
                                    const char* meaning) { visitor.field(key, value, bounds, meaning); });
    }
    void validate() const override { params.validate(); }

    Params params;
  };

  std::unique_ptr<Holder> held_;
};

}  // namespace ratslam
